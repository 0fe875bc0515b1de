//! `slabsplat batch`: a picture of each of many inputs.

use crate::flags::{HowFlags, PictureFlags, SceneFlags, Target, Written, is_same_file};
use crate::plain::counted;
use crate::{render, terminal};
use anyhow::{Result, bail};
use clap::Args;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Render each of many scenes or volumes into a picture of its name; what fails does not stop the others
#[derive(Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct BatchArgs {
    /// What is drawn, each by itself: anything that `render` draws
    #[arg(value_name = "INPUT", required = true, help_heading = "Input")]
    inputs: Vec<PathBuf>,

    /// The folder for the pictures; each is called as its input is
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,

    #[command(flatten)]
    picture: PictureFlags,

    /// Tell on stderr what each frame cost
    #[arg(long)]
    stats: bool,

    /// Answer in JSON: for each input what `render --json` answers, or the error
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    how: HowFlags,
}

pub(crate) fn run(args: BatchArgs) -> Result<()> {
    let targets = targets(&args.inputs, &args.output, &args.picture)?;
    let mut scene = SceneFlags::of(PathBuf::new(), args.how);
    let mut answers = Vec::new();
    let mut failed = Vec::new();
    for (input, target) in args.inputs.iter().zip(targets) {
        scene.set_input(input.clone());
        let written = Written { target, scene: None, picture: &args.picture };
        let answer = render::draw(&scene, &written, args.stats).unwrap_or_else(|error| {
            failed.push(input.display().to_string());
            failure(input, &error)
        });
        answers.push(json!({ "input": input.display().to_string(), "result": answer }));
    }
    if args.json {
        terminal::answer(&format!("{:#}\n", Value::Array(answers)))?;
    }
    let n_inputs = args.inputs.len();
    if !failed.is_empty() {
        let names = failed.join(", ");
        bail!("{} of {} could not be drawn: {names}", failed.len(), counted(n_inputs, "input"));
    }
    let pictures = counted(n_inputs, "picture");
    terminal::say(format_args!("{pictures} in {}", args.output.display()));
    Ok(())
}

/// Tells that an input could not be drawn.
fn failure(input: &Path, error: &anyhow::Error) -> Value {
    let error = terminal::one_line(error);
    let name = input.display().to_string();
    if error.contains(&name) {
        terminal::report(format_args!("error: {error}"));
    } else {
        terminal::report(format_args!("error: {name}: {error}"));
    }
    json!({ "error": error, "warnings": terminal::take_warnings() })
}

/// Where the picture of each input goes. No two are one, and none is an input.
fn targets(inputs: &[PathBuf], folder: &Path, picture: &PictureFlags) -> Result<Vec<Target>> {
    let mut taken = HashMap::new();
    let target = |input: &PathBuf| {
        let Some(name) = picture.name_for(input) else {
            let input = input.display();
            bail!("{input} gives its picture no name: slabsplat render {input} -o FILE draws it");
        };
        let path = folder.join(name);
        if let Some(other) = taken.insert(path.clone(), input.clone()) {
            let [other, input] = [&other, input].map(|input| input.display());
            bail!("{other} and {input} would both be drawn into {}", path.display());
        }
        if inputs.iter().any(|input| is_same_file(input, &path)) {
            bail!(
                "{} is to be drawn, and would be replaced: choose another folder",
                path.display()
            );
        }
        picture.target(path)
    };
    inputs.iter().map(target).collect()
}
