//! `slabsplat reproduce`: the paper's figures and tables as one page, ours beside what is printed.
//!
//! A section of the page is a file: [`table_1`], [`faces`] (figures 2 and 6), [`slab_widths`] (figure 7, of
//! the same [`cube`]), [`darkening`] (figure 8), [`turning`] (figure 9) and [`times`] (§5). Their scenes and
//! what is read off pictures are the library's, in `slabsplat::paper`; [`page`], [`html`] and [`plot`] only
//! say how it looks.

mod page;

mod cube;
mod darkening;
mod faces;
mod slab_widths;
mod table_1;
mod times;
mod turning;

mod volumes;

mod html;
mod plot;

use crate::progress::Progress;
use crate::{advice, columns, output, stats, terminal};
use anyhow::{Context, Result, bail};
use clap::Args;
use page::Section;
use slabsplat::{Image, Method, PoppingReport, Renderer, Scene, Sweep};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Reproduce the paper's figures and tables as one page
///
/// The page has Table 1, figures 2, 6, 7, 8 and views like figure 9, and the times of §5, ours beside the
/// printed values, with what agrees and what does not. It is one file that needs no other: pictures are
/// within. All volumes are built in. A page that is there already is made anew; any other file of its name is
/// left alone.
#[derive(Args)]
pub(crate) struct ReproduceArgs {
    /// Where the page goes, as index.html; the folder is made if there is none
    #[arg(value_name = "FOLDER", default_value = "reproduce")]
    folder: PathBuf,

    /// What executes the frames; the CPU has all of the paper's methods
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    backend: String,
}

/// Makes a section.
type MakeSection = fn(&mut Studio) -> Result<Section>;

const SECTIONS: [MakeSection; 6] = [
    table_1::section,
    faces::section,
    slab_widths::section,
    darkening::section,
    turning::section,
    times::section,
];

pub(crate) fn run(args: &ReproduceArgs) -> Result<()> {
    let path = args.folder.join("index.html");
    check_page(&path)?;
    std::fs::create_dir_all(&args.folder)
        .with_context(|| format!("cannot make the folder {}", args.folder.display()))?;
    let mut studio = Studio { renderer: Renderer::open(&args.backend, terminal::warn)? };
    let progress = Progress::start("reproducing", SECTIONS.len());
    let sections = SECTIONS.iter().map(|section| {
        let section = section(&mut studio);
        progress.step();
        section
    });
    let sections = sections.collect::<Result<Vec<_>>>()?;
    drop(progress);
    let page = page::page(&sections, &machine(&studio.renderer));
    output::write_text(&path, &page)?;
    terminal::answer(&answer(&path, &page, &sections))
}

/// That nothing is lost where the page goes.
fn check_page(path: &Path) -> Result<()> {
    match std::fs::read(path) {
        Ok(there) if page::is_ours(&String::from_utf8_lossy(&there)) => Ok(()),
        Ok(_) => bail!(
            "{} is there, and slabsplat reproduce did not make it: name another folder",
            path.display()
        ),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error).with_context(|| format!("cannot write {}", path.display())),
    }
}

fn answer(path: &Path, page: &str, sections: &[Section]) -> String {
    let claims = sections.iter().flat_map(|section| &section.claims);
    let n_claims = claims.clone().count();
    let n_agreeing = claims.filter(|claim| claim.agrees).count();
    format!(
        "{}: {}, {n_agreeing} of {n_claims} statements of the paper agree\n",
        path.display(),
        columns::bytes(page.len() as u64)
    )
}

/// What drew the page, as its reader would name it.
fn machine(renderer: &Renderer) -> String {
    let executor = stats::executor(renderer.caps());
    match processor().filter(|_| renderer.caps().name == "cpu") {
        Some(processor) => format!("{executor} ({processor})"),
        None => executor,
    }
}

/// The processor's name, where the system tells it.
fn processor() -> Option<String> {
    let info = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let name = info.lines().find(|line| line.starts_with("model name"))?;
    Some(name.split_once(':')?.1.trim().to_owned())
}

/// What draws and measures.
struct Studio {
    renderer: Renderer,
}

impl Studio {
    fn draw(&mut self, scene: &Scene) -> Result<Image> {
        Ok(advice::render(&mut self.renderer, scene)?.image)
    }

    fn popping(&mut self, scene: &Scene, method: Method, sweep: Sweep) -> Result<PoppingReport> {
        advice::popping(&mut self.renderer, scene, method, sweep, || ())
    }
}

/// A method by its name and the paper's.
fn title(method: Method) -> &'static str {
    match method {
        Method::ImageAligned => "image-aligned (the paper’s)",
        Method::AxisAligned => "axis-aligned (the traditional)",
        Method::EverySample => "every-sample (the original)",
        Method::PostClassified => "post-classified",
    }
}

/// The methods that the paper has.
const METHODS: [Method; 3] = [Method::AxisAligned, Method::ImageAligned, Method::EverySample];

/// The red channel of a picture, which is grey.
fn red(image: &Image) -> impl Fn(u32, u32) -> f64 + '_ {
    |x, y| image.pixel(x, y)[0].into()
}

/// A number that may not be there.
fn or_dash(number: Option<f64>) -> String {
    number.map_or("–".to_owned(), |number| format!("{number:.2}"))
}
