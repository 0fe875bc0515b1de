//! Loops in AMD's assembly as the driver prints it: blocks with a label each, and branches that name them.

use std::collections::BTreeMap;

/// The instructions of the longest innermost loop that reads workgroup memory, 0 if there is none. In a
/// stage that splats that is the loop over staged splats, which every pixel runs through.
pub(super) fn innermost_loop<'a>(lines: impl Iterator<Item = &'a str>) -> u64 {
    let code = Code::of(lines);
    let loops = code.loops();
    let is_innermost = |(begin, end): &(usize, usize)| {
        !loops.iter().any(|other| *other != (*begin, *end) && *begin <= other.0 && other.1 <= *end)
    };
    let reads = |(begin, end): &(usize, usize)| {
        code.instructions[*begin..=*end].iter().any(|it| it.starts_with("ds_read"))
    };
    let lengths = loops.iter().filter(|it| is_innermost(it) && reads(it));
    lengths.map(|(begin, end)| (end - begin + 1) as u64).max().unwrap_or(0)
}

/// Instructions, and where each block begins among them.
struct Code<'a> {
    instructions: Vec<&'a str>,
    blocks: BTreeMap<&'a str, usize>,
}

impl<'a> Code<'a> {
    fn of(lines: impl Iterator<Item = &'a str>) -> Self {
        let mut code = Self { instructions: Vec::new(), blocks: BTreeMap::new() };
        for line in lines {
            // The machine's code follows as a comment.
            let text = line.split(';').next().unwrap_or_default().trim();
            if let Some(label) = text.strip_suffix(':') {
                code.blocks.insert(label, code.instructions.len());
            } else if !text.is_empty() {
                code.instructions.push(text);
            }
        }
        code
    }

    /// From the block that a branch goes back to, to the last branch that does.
    fn loops(&self) -> Vec<(usize, usize)> {
        let mut ends = BTreeMap::new();
        for (place, instruction) in self.instructions.iter().enumerate() {
            let words: Vec<&str> = instruction.split_whitespace().collect();
            let is_branch = words[0].starts_with("s_branch") || words[0].starts_with("s_cbranch");
            let target = words.last().filter(|_| is_branch).and_then(|it| self.blocks.get(it));
            if let Some(&begin) = target.filter(|begin| **begin <= place) {
                ends.insert(begin, place);
            }
        }
        ends.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn innermost_loop_of_two() {
        let code = "BB0:\n\ts_mov_b32 s0, s3 ; be800303\nBB1:\n\ts_cbranch_scc1 BB4 ; bf85\n\
                    BB2:\n\tds_read_b32 v1, v2\n\tv_add_f32_e32 v0, v0, v1\n\ts_cbranch_scc1 BB2\n\
                    \ts_branch BB1\nBB3:\n\tbuffer_load_dword v1\n\ts_nop 0\n\ts_nop 0\n\ts_nop 0\n\
                    \ts_cbranch_scc0 BB3\nBB4:\n\ts_endpgm\n";
        assert_eq!(
            innermost_loop(code.lines()),
            3,
            "the outer one, and one of other memory, do not count"
        );
        assert_eq!(innermost_loop("BB0:\n\ts_endpgm".lines()), 0);
    }
}
