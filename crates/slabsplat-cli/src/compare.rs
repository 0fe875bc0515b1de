//! `slabsplat compare`: one scene by several settings, side by side, with differences and figures.

use crate::flags::{SceneFlags, check_folder};
use crate::plain::counted;
use crate::progress::Progress;
use crate::render::nothing_visible;
use crate::{advice, columns, output, terminal};
use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use serde_json::{Value, json};
use slabsplat::io::{IoError, PictureFormat, Provenance, SceneFile};
use slabsplat::{
    FrameHandle, Image, ImageDesc, ImageDifference, Method, OpenScene, Pane, PoppingReport,
    Renderer, Sheet, SheetDesc, Sweep, Variant, Vary, difference_picture, gain_for, variants,
};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Compare pictures of a scene by several methods or settings
///
/// Any setting is varied by --vary, such as --vary slab-width=1,2,4 --vary kernel=gaussian,crawfis-max;
/// without it all methods are compared. The sheet has every combination, and below each where it differs from
/// the reference: white is no difference, red more and blue less, of the channel that differs most; what
/// exceeds the scale is magenta and green. Figures are of premultiplied channels, 0 to 1: the largest and the
/// mean difference of all four, and the PSNR of red, green and blue as on black. What cannot be drawn says
/// why.
#[derive(Args)]
pub(crate) struct CompareArgs {
    /// The sheet of all pictures, in any format that `render` writes
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Write every picture and difference by itself, too, into this folder
    #[arg(long, value_name = "FOLDER")]
    panes: Option<PathBuf>,

    /// A setting and its values; given twice or more, all combinations [default: method, all of them]
    #[arg(long, value_name = "SETTING=VALUE,..")]
    vary: Vec<Vary>,

    /// What the others are compared with [default: the first combination]
    #[arg(long, value_name = "SETTING=VALUE")]
    reference: Vec<Vary>,

    /// Factor of differences in pictures [default: so that the largest is within the scale]
    #[arg(long, value_name = "N", value_parser = positive)]
    gain: Option<f64>,

    /// Measure popping, too: over a turn of 5 degrees about the scene's camera, in steps of half a degree
    #[arg(long)]
    popping: bool,

    /// Leave the scene out of the pictures' metadata: a sheet says which scene it compares, and a picture of
    /// --panes which one it shows
    #[arg(long)]
    no_metadata: bool,

    /// Make the sheet's folder if it is not there
    #[arg(long)]
    mkdir: bool,

    /// Answer in JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    scene: SceneFlags,
}

fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| format!("{text:?} is not a number"))?;
    let is_one = (1e-6..=1e6).contains(&number);
    if is_one { Ok(number) } else { Err("a gain is from 0.000001 to 1000000".to_owned()) }
}

const TURN: Sweep = Sweep::turn(-2.5, 2.5).step(0.5);

/// Pictures in a row of a sheet, where one setting is varied.
const COLUMNS: usize = 4;

/// What one combination gave.
struct Compared {
    variant: Variant,
    drawn: Result<Drawn, String>,
}

struct Drawn {
    image: Image,
    ms: f64,
    /// Why nothing is visible, if nothing is.
    blank: Option<String>,
    popping: Option<PoppingReport>,
}

pub(crate) fn run(args: &CompareArgs) -> Result<()> {
    let varied = varied(args)?;
    let all = variants(&varied)?;
    let reference = reference(args, &all)?;
    let format = args.output.as_deref().map(|path| format_of(path, args.mkdir)).transpose()?;
    if let Some(folder) = &args.panes {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let progress = Progress::start("reading", 0);
    let check = |file: &SceneFile| {
        let sheet = args.output.is_some().then(|| sheet(&file.image, &varied, all.len()));
        sheet.transpose().map(drop)
    };
    let (mut renderer, mut opened) = args.scene.opened(&progress, &check)?;
    drop(progress);
    if !args.scene.says_gradients() {
        // What was found by gradients cannot be drawn by all that are compared.
        opened.scene.layers.iter_mut().for_each(|layer| layer.gradient_opacity = None);
    }
    let sheet = args
        .output
        .is_some()
        .then(|| sheet(&opened.scene.image, &varied, all.len()))
        .transpose()?;
    let compared =
        args.scene.in_scene(|| Ok(draw_all(&mut renderer, &opened, all, args.popping)))?;
    let comparison = Comparison::of(compared, reference, args.gain)?;
    comparison.warn_of_blanks();
    renderer.caps().name.clone_into(&mut opened.backend);
    let writes = args.output.is_some() || args.panes.is_some();
    let file = (writes && !args.no_metadata).then(|| opened.to_file()).transpose()?;
    if let (Some(path), Some(format), Some(sheet)) = (&args.output, format, sheet) {
        let about = file.as_ref().and_then(|file| provenance(file, path));
        output::write_picture(path, format, &comparison.sheet(&sheet), about.as_ref())?;
    }
    if let Some(folder) = &args.panes {
        let scene_of = |variant: &Variant| {
            file.as_ref()
                .map(|file| Ok(file.at_moment(&variant.applied(&opened.scene)?)?))
                .transpose()
        };
        comparison.write_panes(folder, scene_of)?;
    }
    let text = if args.json { format!("{:#}\n", comparison.json()) } else { comparison.text() };
    terminal::answer(&text)
}

fn varied(args: &CompareArgs) -> Result<Vec<Vary>> {
    if !args.vary.is_empty() {
        return Ok(args.vary.clone());
    }
    Ok(vec![format!("method={}", Method::NAMES.join(",")).parse()?])
}

/// The index of what the others are compared with.
fn reference(args: &CompareArgs, all: &[Variant]) -> Result<usize> {
    let is_it = |variant: &Variant| args.reference.iter().all(|vary| variant.has(vary));
    all.iter().position(is_it).ok_or_else(|| {
        anyhow!("the --reference is none of what is compared: vary it to that value, too")
    })
}

fn format_of(path: &Path, makes_folders: bool) -> Result<PictureFormat> {
    let Some(format) = PictureFormat::of_name(path) else {
        return Err(IoError::UnknownPicture { path: path.to_owned() }.into());
    };
    check_folder(path, makes_folders)?;
    Ok(format)
}

/// What a picture is to say of itself.
fn provenance(scene: &SceneFile, path: &Path) -> Option<Provenance> {
    let about = Provenance::of_scene(scene, path);
    about.map_err(|error| terminal::warn(&format!("{}: {error}", path.display()))).ok()
}

/// A column for each value of the last setting, if two or more are varied.
fn sheet(image: &ImageDesc, varied: &[Vary], n_panes: usize) -> Result<Sheet> {
    let n_columns = match varied {
        [_, .., last] => last.n_values(),
        _ => n_panes.min(COLUMNS),
    };
    let pane_size = [image.width, image.height];
    Sheet::new(SheetDesc::new(n_panes, n_columns, pane_size)).map_err(|error| {
        anyhow!(
            "{error}: a sheet of {} needs smaller pictures, by --width and --height",
            counted(n_panes, "picture")
        )
    })
}

fn draw_all(
    renderer: &mut Renderer,
    opened: &OpenScene,
    all: Vec<Variant>,
    measures_popping: bool,
) -> Vec<Compared> {
    let progress = Progress::start("comparing", all.len());
    let compare = |variant: Variant| {
        let drawn = draw(renderer, opened, &variant, measures_popping);
        progress.step();
        Compared { variant, drawn: drawn.map_err(|error| terminal::one_line(&error)) }
    };
    all.into_iter().map(compare).collect()
}

/// A frame comes first that does not count: it reads, sorts and makes tables.
fn draw(
    renderer: &mut Renderer,
    opened: &OpenScene,
    variant: &Variant,
    measures_popping: bool,
) -> Result<Drawn> {
    let scene = variant.applied(&opened.scene)?;
    advice::render(renderer, &scene)?;
    let frame = FrameHandle::new();
    let started = Instant::now();
    let picture = advice::picture(renderer, &scene, opened.acquisition, &frame)?;
    let ms = started.elapsed().as_secs_f64() * 1e3;
    let blank = picture.is_blank.then(|| nothing_visible(&scene, &picture.frame));
    let mut popping = None;
    if measures_popping {
        let method = scene.settings.method;
        popping = Some(advice::popping(renderer, &scene, method, TURN, || ())?);
    }
    Ok(Drawn { image: picture.frame.image, ms, blank, popping })
}

/// All that is answered.
struct Comparison {
    all: Vec<Compared>,
    /// Of each, from the reference's picture.
    differences: Vec<Option<ImageDifference>>,
    reference: Image,
    reference_label: String,
    gain: f64,
}

impl Comparison {
    fn of(all: Vec<Compared>, reference: usize, gain: Option<f64>) -> Result<Self> {
        let reference_label = all[reference].variant.label();
        let reference = match &all[reference].drawn {
            Ok(drawn) => drawn.image.clone(),
            Err(why) => bail!("the reference, {reference_label}, cannot be drawn: {why}"),
        };
        let difference = |compared: &Compared| {
            let drawn = compared.drawn.as_ref().ok()?;
            Some(ImageDifference::between(&drawn.image, &reference))
        };
        let differences: Vec<_> = all.iter().map(difference).collect();
        let largest = differences.iter().flatten().map(|d| d.largest).fold(0.0, f32::max);
        let gain = gain.unwrap_or_else(|| gain_for(largest.into()));
        Ok(Self { all, differences, reference, reference_label, gain })
    }

    /// Empty pictures are all the same, which is not what somebody wants to know.
    fn warn_of_blanks(&self) {
        for compared in &self.all {
            let drawn = compared.drawn.as_ref().ok();
            if let Some(why) = drawn.and_then(|drawn| drawn.blank.as_ref()) {
                terminal::warn(&format!("{}: nothing is visible: {why}", compared.variant.label()));
            }
        }
    }

    fn difference_picture(&self, image: &Image) -> Image {
        difference_picture(image, &self.reference, self.gain)
    }

    fn sheet(&self, sheet: &Sheet) -> Image {
        let pane = |(compared, difference): (&Compared, &Option<ImageDifference>)| {
            let pictures = match &compared.drawn {
                Ok(drawn) => Ok([drawn.image.clone(), self.difference_picture(&drawn.image)]),
                Err(why) => Err(why.clone()),
            };
            let figures = difference.map_or(String::new(), |d| {
                let psnr = decibels(d.psnr_db);
                format!("PSNR {psnr}, largest {:.4}, mean {:.5}", d.largest, d.mean)
            });
            Pane::new(compared.variant.label(), pictures, figures)
        };
        let panes: Vec<Pane> = self.all.iter().zip(&self.differences).map(pane).collect();
        let scale = format!(
            "Below each picture: its difference from {} × {}, of the channel that differs most; magenta and \
             green lie beyond the scale",
            self.reference_label,
            rounded(self.gain)
        );
        sheet.draw(&panes, &scale, 1.0 / self.gain)
    }

    fn write_panes(
        &self,
        folder: &Path,
        scene_of: impl Fn(&Variant) -> Result<Option<SceneFile>>,
    ) -> Result<()> {
        for compared in &self.all {
            let Ok(drawn) = &compared.drawn else { continue };
            let name = compared.variant.label().replace(", ", "-").replace(' ', "-");
            let path = folder.join(format!("{name}.png"));
            let scene = scene_of(&compared.variant)?;
            let about = scene.and_then(|scene| provenance(&scene, &path));
            output::write_picture(&path, PictureFormat::Png, &drawn.image, about.as_ref())?;
            let path = folder.join(format!("{name}-difference.png"));
            let difference = self.difference_picture(&drawn.image);
            output::write_picture(&path, PictureFormat::Png, &difference, None)?;
        }
        Ok(())
    }

    fn text(&self) -> String {
        let head = ["", "PSNR", "largest", "mean", "ms", "pop ratio", "jitter"].map(str::to_owned);
        let mut rows = vec![head];
        for (compared, difference) in self.all.iter().zip(&self.differences) {
            let label = compared.variant.label();
            let (Ok(drawn), Some(d)) = (&compared.drawn, difference) else { continue };
            let popping = drawn.popping.as_ref();
            let [ratio, jitter] =
                [popping.and_then(|p| p.pop_ratio), popping.and_then(|p| p.jitter)]
                    .map(|number| number.map_or("-".to_owned(), |number| format!("{number:.2}")));
            let [largest, mean] = [format!("{:.5}", d.largest), format!("{:.6}", d.mean)];
            rows.push([
                label,
                decibels(d.psnr_db),
                largest,
                mean,
                format!("{:.1}", drawn.ms),
                ratio,
                jitter,
            ]);
        }
        let mut text = columns::aligned(&rows);
        for compared in &self.all {
            if let Err(why) = &compared.drawn {
                text += &format!("{}: not drawn: {why}\n", compared.variant.label());
            }
        }
        text + &format!(
            "\nDifferences are from {}; in pictures times {}.\n",
            self.reference_label,
            rounded(self.gain)
        )
    }

    fn json(&self) -> Value {
        let of = |(compared, difference): (&Compared, &Option<ImageDifference>)| {
            let drawn = compared.drawn.as_ref().ok();
            let popping = drawn.and_then(|drawn| drawn.popping.as_ref());
            let settings =
                compared.variant.values().map(|(name, value)| (name.to_owned(), value.into()));
            json!({
                "settings": settings.collect::<serde_json::Map<_, _>>(),
                "error": compared.drawn.as_ref().err(),
                "psnr_db": difference.map(|d| d.psnr_db),
                "largest": difference.map(|d| d.largest),
                "mean": difference.map(|d| d.mean),
                "ms": drawn.map(|drawn| drawn.ms),
                "pop_ratio": popping.map(|popping| popping.pop_ratio),
                "jitter": popping.map(|popping| popping.jitter),
            })
        };
        json!({
            "reference": self.reference_label,
            "gain": self.gain,
            "compared": self.all.iter().zip(&self.differences).map(of).collect::<Vec<_>>(),
        })
    }
}

/// A ratio in decibels; infinite is the same picture.
fn decibels(ratio: f64) -> String {
    if ratio == f64::INFINITY { "same".to_owned() } else { format!("{ratio:.2} dB") }
}

/// Without the digits that dividing by a decimal fraction leaves behind.
fn rounded(gain: f64) -> f64 {
    (gain * 1e6).round() / 1e6
}
