//! The compute shaders of slabsplat, which both GPU backends run.
//!
//! There is one source, the WGSL files of `shaders/`: a stage a file, called as its entry point, with
//! common code in `shaders/shared/` that a stage takes in by a line `//#include "shared/…"`. When this crate
//! is built, naga validates every stage (a mistake in a shader is an error of the build), reflects its
//! bindings and the layouts of its structs, and translates it to SPIR-V. So nobody writes a binding's
//! number twice, and no other compiler is needed.
//!
//! Stages ask for no more than every WebGPU device has: workgroups of at most 256, at most 8 storage
//! buffers, one bind group, no subgroups, no 16-bit floats, and no atomics but on `u32`.
//!
//! ```
//! use slabsplat_shaders::{BindingKind, SPLAT_SECTIONS};
//!
//! assert_eq!(SPLAT_SECTIONS.bindings[0].name, "frame");
//! assert_eq!(SPLAT_SECTIONS.bindings[0].kind, BindingKind::Uniform);
//! ```

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// A compute shader, ready for WebGPU (its source) and for Vulkan (its SPIR-V).
#[derive(Debug, PartialEq, Eq)]
pub struct Shader {
    /// The name of its file and of its entry point.
    pub name: &'static str,
    /// The whole source, with all that it includes.
    pub wgsl: &'static str,
    /// The same as SPIR-V 1.3, with descriptor set and binding numbers as in the source.
    pub spirv: &'static [u32],
    /// Threads of a workgroup along x, y, z.
    pub workgroup_size: [u32; 3],
    /// What is bound in group 0, by number.
    pub bindings: &'static [Binding],
}

/// A buffer that a shader sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// The variable's name.
    pub name: &'static str,
    /// What it does with it.
    pub kind: BindingKind,
}

/// What a shader does with a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// A small struct that is the same for all threads.
    Uniform,
    /// Storage that it only reads.
    Read,
    /// Storage that it may write.
    Written,
}

/// How a struct lies in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// Its name.
    pub name: &'static str,
    /// Bytes from one to the next in an array.
    pub size: u32,
    /// Its members, in order.
    pub members: &'static [Member],
}

/// A member of a struct.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: &'static str,
    /// Bytes from the struct's start.
    pub offset: u32,
    /// Bytes that it takes.
    pub size: u32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;
    use std::io::Write;
    use std::process::{Command, Stdio};

    /// What every WebGPU device has.
    #[test]
    fn shaders_stay_within_portable_limits() {
        for shader in ALL {
            let n_threads: u32 = shader.workgroup_size.iter().product();
            assert!(n_threads <= 256, "{}: workgroups of {n_threads}", shader.name);
            let is_storage = |b: &&Binding| b.kind != BindingKind::Uniform;
            let n_storage = shader.bindings.iter().filter(is_storage).count();
            assert!(n_storage <= 8, "{}: {n_storage} storage buffers", shader.name);
        }
    }

    /// What stands between two operators of one expression.
    fn is_operand(text: &str) -> bool {
        !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || "_. ".contains(c))
    }

    /// Whether a shift and a bitwise operator share an operand: naga takes it, WGSL does not.
    fn mixes_shifts(line: &str) -> bool {
        let code = line.split("//").next().unwrap_or_default();
        let code = code.replace("<<", "≪").replace(">>", "≪");
        let operators: Vec<usize> =
            code.match_indices(['≪', '|', '&', '^']).map(|(at, _)| at).collect();
        operators.windows(2).any(|pair| {
            let [first, second] = [pair[0], pair[1]].map(|at| code[at..].chars().next());
            let after_first = pair[0] + first.map_or(0, char::len_utf8);
            (first == Some('≪')) != (second == Some('≪')) && is_operand(&code[after_first..pair[1]])
        })
    }

    #[test]
    fn shifts_are_in_parentheses() {
        for mixed in ["return a.y << 16u | b.x;", "a | b >> 2u", "x & y.z << n"] {
            assert!(mixes_shifts(mixed), "{mixed}");
        }
        for plain in ["(a << 16u) | b", "a | (b >> 2u)", "a << 2u // | b", "f(a << 2u, b | c)"] {
            assert!(!mixes_shifts(plain), "{plain}");
        }
        for shader in ALL {
            let mixed = shader.wgsl.lines().find(|line| mixes_shifts(line));
            assert_eq!(mixed, None, "{}: no browser takes this", shader.name);
        }
    }

    /// A struct that two shaders share must be one struct.
    #[test]
    fn structs_have_one_layout() {
        let mut by_name = HashMap::new();
        for layout in STRUCTS {
            assert!(by_name.insert(layout.name, layout).is_none(), "{} twice", layout.name);
        }
    }

    /// Whoever runs them need not ask a device for more.
    #[test]
    fn shaders_need_no_more_than_compute() {
        const CAPABILITY: u32 = 17;
        const SHADER: u32 = 1;
        for shader in ALL {
            let mut rest = &shader.spirv[5..];
            while let [first, operands @ ..] = rest {
                let [opcode, n_words] = [first & 0xffff, first >> 16];
                let is_more = opcode == CAPABILITY && operands[0] != SHADER;
                assert!(!is_more, "{}: capability {}", shader.name, operands[0]);
                rest = &rest[n_words as usize..];
            }
        }
    }

    /// By the judgement of Khronos' own validator, where it is installed.
    #[test]
    fn shaders_are_valid_spirv() {
        for shader in ALL {
            assert_eq!(shader.spirv[0], 0x0723_0203, "{}: the magic number", shader.name);
            let mut validator = Command::new("spirv-val");
            validator.args(["--target-env", "vulkan1.2", "-"]);
            let Ok(mut child) = validator.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn()
            else {
                println!("skipped: spirv-val is not installed");
                return;
            };
            let bytes: Vec<u8> = shader.spirv.iter().flat_map(|word| word.to_le_bytes()).collect();
            child.stdin.take().unwrap().write_all(&bytes).unwrap();
            let output = child.wait_with_output().unwrap();
            let diagnostic = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}: {diagnostic}", shader.name);
        }
    }
}
