//! The tables as Rust source.

use crate::reflect::{Reflected, Struct};
use std::fmt::Write;

pub(crate) fn tables(shaders: &[Reflected]) -> String {
    let mut out = String::new();
    for shader in shaders {
        write_shader(&mut out, shader);
    }
    let names: Vec<String> = shaders.iter().map(|shader| constant(&shader.name)).collect();
    let names: Vec<String> = names.iter().map(|name| format!("&{name}")).collect();
    let _ = writeln!(out, "/// All shaders, by name.");
    let _ = writeln!(out, "pub static ALL: &[&Shader] = &[{}];", names.join(", "));
    write_structs(&mut out, shaders);
    out
}

fn constant(name: &str) -> String {
    name.to_uppercase()
}

fn write_shader(out: &mut String, shader: &Reflected) {
    let Reflected { name, wgsl, spirv, workgroup_size, bindings, .. } = shader;
    let bindings: Vec<String> = bindings
        .iter()
        .map(|b| format!("Binding {{ name: {:?}, kind: BindingKind::{} }}", b.name, b.kind))
        .collect();
    let _ = writeln!(
        out,
        "/// `shaders/{name}.wgsl`.\n\
         pub static {}: Shader = Shader {{ name: {name:?}, wgsl: {wgsl:?}, spirv: &{spirv:?}, \
         workgroup_size: {workgroup_size:?}, bindings: &[{}] }};",
        constant(name),
        bindings.join(", "),
    );
}

/// Every struct once; two shaders that share one include the same file.
fn write_structs(out: &mut String, shaders: &[Reflected]) {
    let mut structs: Vec<&Struct> = Vec::new();
    for layout in shaders.iter().flat_map(|shader| &shader.structs) {
        if !structs.contains(&layout) {
            structs.push(layout);
        }
    }
    let _ = writeln!(out, "/// The layouts of all structs that shaders declare.");
    let _ = writeln!(out, "pub static STRUCTS: &[StructLayout] = &[");
    for Struct { name, size, members } in structs {
        let member = |(name, offset, size): &(String, u32, u32)| {
            format!("Member {{ name: {name:?}, offset: {offset}, size: {size} }}")
        };
        let members: Vec<String> = members.iter().map(member).collect();
        let members = members.join(", ");
        let _ = writeln!(
            out,
            "StructLayout {{ name: {name:?}, size: {size}, members: &[{members}] }},"
        );
    }
    let _ = writeln!(out, "];");
}
