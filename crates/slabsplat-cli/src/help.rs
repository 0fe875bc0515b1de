//! What `--help` shows beside each flag: which flags are for experts, and examples.
//!
//! `-h` leaves the experts' flags out; `--help` has them last, under headings of their own.

use clap::{Arg, Command};

/// Flags of a raw file, which few volumes are.
const RAW_FILES: Group =
    Group { heading: "Raw files", flags: &["dims", "sample_type", "endian", "header_bytes"] };

/// Flags that a good picture seldom needs.
const EXPERTS: Group = Group {
    heading: "For experts",
    flags: &[
        "allow_external",
        "opacity_from",
        "transfer_boxes",
        "transfer_image",
        "gradient_opacity",
        "ambient",
        "diffuse",
        "zero_gradient",
        "specular",
        "shininess",
        "two_sided",
        "crop_index",
        "lit_cuts",
        "kernel",
        "normalization",
        "base_slab_width",
        "sections",
        "radial_samples",
        "lookup",
        "opacity_cutoff",
    ],
};

/// Flags, by their names in the program, that `-h` leaves out.
#[derive(Clone, Copy)]
struct Group {
    heading: &'static str,
    flags: &'static [&'static str],
}

/// Two examples for each command.
const EXAMPLES: &[(&str, [&str; 2])] = &[
    (
        "render",
        [
            "slabsplat render head.nii.gz",
            "slabsplat render ct-folder --preset ct-bone --view front --clip 1,0,0,20 -o cut.png",
        ],
    ),
    #[cfg(feature = "viewer")]
    (
        "view",
        ["slabsplat view head.nii.gz", "slabsplat view ct-folder --preset ct-bone --backend cpu"],
    ),
    #[cfg(feature = "serve")]
    (
        "serve",
        [
            "slabsplat serve head.nii.gz",
            "slabsplat serve ct-folder --preset ct-bone --port 0 --sessions 2",
        ],
    ),
    (
        "batch",
        [
            "slabsplat batch a.nrrd b.nrrd ct-folder -o pictures --mkdir",
            "slabsplat batch a.toml b.toml -o pictures --width 1200 --height 1200 --json",
        ],
    ),
    (
        "turntable",
        [
            "slabsplat turntable head.nii.gz -o head.mp4",
            "slabsplat turntable ct-folder --preset ct-bone -o bone.gif --rock --seconds 4 --fps 20",
        ],
    ),
    (
        "film",
        [
            "slabsplat film head.toml -o head.mp4",
            "slabsplat film head.toml -o head.webp --width 800 --height 600",
        ],
    ),
    ("scene", ["slabsplat scene head.nii.gz -o head.toml", "slabsplat scene head.png"]),
    ("info", ["slabsplat info head.nii.gz", "slabsplat info ct-folder --json"]),
    (
        "convert",
        [
            "slabsplat convert ct-folder ct.nii.gz",
            "slabsplat convert stack.ome.tif --channel 1 green.nrrd",
        ],
    ),
    (
        "tf",
        [
            "slabsplat tf --preset ct-bone -o bone.png",
            "slabsplat tf head.nii.gz --window 100:900 --json",
        ],
    ),
    ("presets", ["slabsplat presets", "slabsplat presets --json"]),
    ("demo", ["slabsplat demo", "slabsplat demo tour"]),
    (
        "popping",
        [
            "slabsplat popping builtin:neuron",
            "slabsplat popping head.nii.gz --method axis-aligned --to 90 --step 1",
        ],
    ),
    (
        "compare",
        [
            "slabsplat compare head.nii.gz -o methods.png",
            "slabsplat compare head.nii.gz --vary slab-width=0.5,1,2,4 --popping -o widths.png",
        ],
    ),
    ("reproduce", ["slabsplat reproduce", "slabsplat reproduce paper --backend cpu"]),
    (
        "bench",
        [
            "slabsplat bench head.nii.gz",
            "slabsplat bench head.toml --frames 20 --backend wgpu --json",
        ],
    ),
    ("backends", ["slabsplat backends", "slabsplat backends --json"]),
    (
        "completions",
        [
            "slabsplat completions bash > ~/.local/share/bash-completion/completions/slabsplat",
            "slabsplat completions fish > ~/.config/fish/completions/slabsplat.fish",
        ],
    ),
];

/// The command with experts' flags apart, and with examples.
pub(crate) fn completed(command: Command) -> Command {
    EXAMPLES.iter().fold(command, |command, (name, examples)| {
        let examples = format!("Examples:\n  {}", examples.join("\n  "));
        command.mut_subcommand(name, |command| grouped(command).after_help(examples))
    })
}

fn grouped(command: Command) -> Command {
    let flags = |group: Group| group.flags.iter().map(move |flag| (group.heading, *flag));
    [RAW_FILES, EXPERTS].into_iter().flat_map(flags).fold(command, |command, (heading, flag)| {
        let has_it = command.get_arguments().any(|arg| arg.get_id() == flag);
        // What is changed goes to the end, and its heading with it.
        let apart = |arg: Arg| arg.help_heading(heading).hide_short_help(true);
        if has_it { command.mut_arg(flag, apart) } else { command }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command_line;

    #[test]
    fn experts_flags_are_there_and_apart() {
        let mut command = command_line();
        let render = command.find_subcommand_mut("render").unwrap();
        let [short, long] =
            [render.render_help(), render.render_long_help()].map(|help| help.to_string());
        for group in [RAW_FILES, EXPERTS] {
            let heading = format!("\n{}:\n", group.heading);
            assert!(!short.contains(&heading) && long.contains(&heading), "{heading}");
            for id in group.flags {
                let arg = render.get_arguments().find(|arg| arg.get_id() == id);
                let flag =
                    format!("--{}", arg.unwrap_or_else(|| panic!("{id}")).get_long().unwrap());
                let is_below = long.find(&heading).unwrap()
                    < long
                        .find(&format!("{flag} <"))
                        .or_else(|| long.find(&format!("{flag}\n")))
                        .unwrap();
                assert!(is_below, "{flag}");
            }
        }
    }

    /// What the program gets of a line in a shell.
    fn words(line: &str) -> Vec<String> {
        let words = shlex::split(line).unwrap();
        let is_the_shells = |word: &String| [">", "<", "|", "#"].contains(&word.as_str());
        words.into_iter().take_while(|word| !is_the_shells(word)).collect()
    }

    fn check_line(line: &str) {
        let parsed = command_line().try_get_matches_from(words(line));
        assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
    }

    /// What people copy from the documents can be typed, too.
    #[test]
    fn documents_have_commands_that_parse() {
        for text in [
            include_str!("../../../README.md"),
            include_str!("../README.md"),
            include_str!("../../../docs/gallery.md"),
            include_str!("../../../docs/formats.md"),
            include_str!("../../../docs/guide/src/tour.md"),
            include_str!("../../../docs/guide/src/pictures.md"),
            include_str!("../../../docs/guide/src/films.md"),
            include_str!("../../../docs/guide/src/methods.md"),
            include_str!("../../../docs/guide/src/serve.md"),
        ] {
            let listings =
                text.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
            let lines = listings.flat_map(str::lines).filter(|line| line.starts_with("slabsplat "));
            let is_of = |line: &str, name: &str| line.starts_with(&format!("slabsplat {name} "));
            let is_here = |line: &&str| {
                (cfg!(feature = "serve") || !is_of(line, "serve"))
                    && (cfg!(feature = "viewer") || !is_of(line, "view"))
            };
            lines.filter(is_here).for_each(check_line);
        }
    }

    /// What is recommended can be typed.
    #[test]
    fn every_command_has_examples_that_parse() {
        for command in command_line().get_subcommands().filter(|command| !command.is_hide_set()) {
            let name = command.get_name();
            let examples = EXAMPLES.iter().find(|(of, _)| *of == name);
            let (_, examples) = examples.unwrap_or_else(|| panic!("{name} has no examples"));
            for example in examples {
                assert!(example.starts_with(&format!("slabsplat {name}")), "{example}");
                check_line(example);
            }
        }
    }
}
