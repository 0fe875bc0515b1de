//! Films of every format, read back by other programs' decoders, and continued.

use image::codecs::{gif::GifDecoder, png::PngDecoder, webp::WebPDecoder};
use image::{AnimationDecoder, ImageDecoder};
use slabsplat_core::Image;
use slabsplat_film::{
    FilmDesc, FilmError, FilmFormat, FilmFrame, FilmWriter, FrameRate, Metadata, Step,
};
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::process::{Command, Stdio};

type Failure = Box<dyn std::error::Error>;

const N_FRAMES: u32 = 7;
const SIZE: [u32; 2] = [21, 13];

fn desc(has_opacity: bool) -> FilmDesc {
    let [width, height] = SIZE;
    let desc = FilmDesc::new(
        width,
        height,
        N_FRAMES,
        FrameRate::new(20.0).expect("films can be written and read"),
    )
    .expect("films can be written and read");
    desc.has_opacity(has_opacity)
}

/// A bright disc that moves over a ramp.
fn frame(frame_idx: u32, opacity: f32) -> Image {
    let [width, height] = SIZE;
    let mut image = Image::filled(width, height, [0.0, 0.0, 0.0, opacity]);
    for (idx, pixel) in image.pixels_mut().iter_mut().enumerate() {
        let [x, y] = [idx as u32 % width, idx as u32 / width];
        let is_disc = (x.abs_diff(3 + 2 * frame_idx)).pow(2) + y.abs_diff(6).pow(2) < 9;
        let ramp = x as f32 / width as f32 * opacity;
        *pixel = if is_disc {
            [0.9, 0.5, 0.1, 1.0]
        } else {
            [0.1 * opacity, ramp, 0.3 * opacity, opacity]
        };
    }
    image
}

fn make(path: &Path, format: FilmFormat, desc: FilmDesc) {
    let opacity = if desc.has_opacity { 0.5 } else { 1.0 };
    let mut steps = Vec::new();
    let film =
        FilmWriter::begin(path, format, desc, "test").expect("films can be written and read");
    let render = |idx| Ok::<_, FilmError>(frame(idx, opacity));
    let report = film.make(render, |step| steps.push(step)).expect("films can be written and read");
    let expected = (1..=N_FRAMES).map(Step::Rendered).chain([Step::Ending]);
    assert_eq!(steps, expected.collect::<Vec<_>>());
    assert_eq!((report.n_frames, report.n_continued), (N_FRAMES, 0));
    assert!((report.seconds - 0.35).abs() < 1e-12 && 0 < report.n_bytes);
    assert!(!path.with_extension("x.frames").exists());
}

/// Frames as a decoder gives them, and how long each is seen, in milliseconds.
fn frames_of(path: &Path, format: FilmFormat) -> Vec<(image::RgbaImage, u32)> {
    let file = BufReader::new(File::open(path).expect("films can be written and read"));
    let frames = match format {
        FilmFormat::Gif => {
            GifDecoder::new(file).expect("films can be written and read").into_frames()
        }
        FilmFormat::WebP => {
            WebPDecoder::new(file).expect("films can be written and read").into_frames()
        }
        _ => PngDecoder::new(file)
            .expect("films can be written and read")
            .apng()
            .expect("it works")
            .into_frames(),
    };
    let frames = frames.collect_frames().expect("films can be written and read").into_iter();
    let delay = |frame: &image::Frame| {
        let (numerator, denominator) = frame.delay().numer_denom_ms();
        numerator / denominator
    };
    frames.map(|frame| (frame.buffer().clone(), delay(&frame))).collect()
}

#[test]
fn lossless_formats_give_back_each_frame() {
    let dir = tempfile::tempdir().unwrap();
    for (format, has_opacity) in [
        (FilmFormat::Apng, false),
        (FilmFormat::Apng, true),
        (FilmFormat::WebP, false),
        (FilmFormat::WebP, true),
    ] {
        let path = dir.path().join(format!("a-{has_opacity}.{}", format.name()));
        make(&path, format, desc(has_opacity));
        let frames = frames_of(&path, format);
        assert_eq!(frames.len(), N_FRAMES as usize, "{format:?}");
        for (idx, (found, delay)) in frames.iter().enumerate() {
            assert_eq!(*delay, 50, "{format:?} {idx}");
            let expected = frame(idx as u32, if has_opacity { 0.5 } else { 1.0 }).to_rgba8();
            assert_eq!(found.as_raw(), &expected, "{format:?} {idx}");
        }
    }
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 4, "no folder of frames is left");
}

#[test]
fn gif_is_close_to_each_frame() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.gif");
    make(&path, FilmFormat::Gif, desc(false));
    let frames = frames_of(&path, FilmFormat::Gif);
    assert_eq!(frames.len(), N_FRAMES as usize);
    for (idx, (found, delay)) in frames.iter().enumerate() {
        assert_eq!((*delay, found.dimensions()), (50, (SIZE[0], SIZE[1])));
        // Of so few colours each is there.
        let expected = frame(idx as u32, 1.0).to_rgba8();
        let differences = found.as_raw().iter().zip(&expected).map(|(a, b)| a.abs_diff(*b));
        assert!(differences.max() <= Some(2), "{idx}");
    }
}

#[test]
fn png_sequence_has_a_file_for_each_frame() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.png-sequence");
    // The second one takes the place of the first.
    for _ in 0..2 {
        make(&path, FilmFormat::PngSequence, desc(true));
        let mut names: Vec<_> = fs::read_dir(&path)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        let expected: Vec<String> =
            (0..N_FRAMES).map(|idx| format!("frame_{idx:05}.png")).collect();
        assert_eq!(names, expected);
    }
    let third = image::open(path.join("frame_00003.png")).unwrap().into_rgba8();
    assert_eq!(third.as_raw(), &frame(3, 0.5).to_rgba8());
    fs::write(path.join("notes.txt"), "x").unwrap();
    let error = FilmWriter::begin(&path, FilmFormat::PngSequence, desc(true), "test").unwrap_err();
    assert!(matches!(error, FilmError::InTheWay { .. }), "{error}");
}

fn has_ffmpeg() -> bool {
    let tools = ["ffmpeg", "ffprobe"].map(|tool| {
        Command::new(tool)
            .arg("-version")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .is_ok()
    });
    let has_both = tools == [true; 2];
    if !has_both {
        eprintln!(
            "skipped: ffmpeg and ffprobe are not installed, so that no MP4 and no WebM is made"
        );
    }
    has_both
}

/// Codec, width, height, frames a second, and frames that are there.
fn probed(path: &Path) -> String {
    let mut command = Command::new("ffprobe");
    command.args(["-v", "error", "-count_frames", "-select_streams", "v", "-of", "csv=p=0"]);
    command.args(["-show_entries", "stream=codec_name,width,height,r_frame_rate,nb_read_frames"]);
    let output = command.arg(path).output().expect("films can be written and read");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("films can be written and read").trim().to_owned()
}

#[test]
fn ffmpeg_formats_have_all_frames() {
    if !has_ffmpeg() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    for (format, codec) in [(FilmFormat::Mp4, "h264"), (FilmFormat::WebM, "vp9")] {
        let path = dir.path().join(format!("a.{}", format.name()));
        make(&path, format, desc(false));
        assert_eq!(
            probed(&path),
            format!("{codec},22,14,20/1,{N_FRAMES}"),
            "odd sides are made even"
        );
        let one = FilmDesc::new(1, 1, 1, FrameRate::new(25.0).unwrap()).unwrap();
        let film = FilmWriter::begin(&path, format, one, "one").unwrap();
        film.make(|_| Ok::<_, FilmError>(Image::filled(1, 1, [1.0; 4])), |_| ()).unwrap();
        assert_eq!(probed(&path), format!("{codec},2,2,25/1,1"));
    }
}

#[test]
fn film_that_is_continued_has_the_same_bytes() {
    let with_ffmpeg = has_ffmpeg();
    let formats = FilmFormat::ALL.iter().filter(|format| with_ffmpeg || !format.needs_ffmpeg());
    for &format in formats {
        let dir = tempfile::tempdir().unwrap();
        let [at_once, continued] =
            ["a", "b"].map(|name| dir.path().join(format!("{name}.{}", format.name())));
        make(&at_once, format, desc(false));
        let begin = || FilmWriter::begin(&continued, format, desc(false), "test").unwrap();
        for (n_done, n_more) in [(0, 2), (2, 3)] {
            let film = begin();
            assert_eq!(film.n_done(), n_done, "{format:?}");
            let render = |idx| {
                if idx < n_done + n_more {
                    Ok(frame(idx, 1.0))
                } else {
                    Err(Failure::from("power cut"))
                }
            };
            let error = film.make(render, |_| ()).unwrap_err();
            assert_eq!(error.to_string(), "power cut");
            assert!(!continued.exists());
        }
        let film = begin();
        let report = film.make(|idx| Ok::<_, FilmError>(frame(idx, 1.0)), |_| ()).unwrap();
        assert_eq!(report.n_continued, 5, "{format:?}");
        let bytes = |path: &Path| match format {
            FilmFormat::PngSequence => (0..N_FRAMES)
                .flat_map(|idx| fs::read(path.join(format!("frame_{idx:05}.png"))).unwrap())
                .collect(),
            _ => fs::read(path).unwrap(),
        };
        assert!(bytes(&at_once) == bytes(&continued), "{format:?}");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2, "{format:?}");
    }
}

/// Whichever frames are damaged or gone, the film is that of a run that nothing happened to.
#[test]
fn film_draws_damaged_frames_again() {
    for format in [FilmFormat::Gif, FilmFormat::WebP, FilmFormat::Apng, FilmFormat::PngSequence] {
        let dir = tempfile::tempdir().unwrap();
        let [whole, mended] =
            ["a", "b"].map(|name| dir.path().join(format!("{name}.{}", format.name())));
        make(&whole, format, desc(false));
        let begin = || FilmWriter::begin(&mended, format, desc(false), "test").unwrap();
        let five =
            |idx| if idx < 5 { Ok(frame(idx, 1.0)) } else { Err(Failure::from("power cut")) };
        begin().make(five, |_| ()).unwrap_err();
        let frames = dir.path().join(format!("b.{}.frames", format.name()));
        let path = |idx: u32| frames.join(format!("frame_{idx:05}.png"));
        fs::write(path(1), "").unwrap();
        fs::remove_file(path(3)).unwrap();
        let mut steps = Vec::new();
        let film = begin();
        assert_eq!(film.n_done(), 4);
        let report =
            film.make(|idx| Ok::<_, FilmError>(frame(idx, 1.0)), |step| steps.push(step)).unwrap();
        assert_eq!(report.n_continued, 3, "{format:?}");
        assert!(
            matches!(&steps[0], Step::Damaged { frame_idx: 1, what } if what.contains("is damaged")),
            "{steps:?}"
        );
        let rendered = [4, 5, 6, 7].map(Step::Rendered);
        assert_eq!(steps[1..5], rendered, "{format:?}");
        let bytes = |path: &Path| match format {
            FilmFormat::PngSequence => fs::read(path.join("frame_00001.png")).unwrap(),
            _ => fs::read(path).unwrap(),
        };
        assert!(bytes(&whole) == bytes(&mended), "{format:?}");
    }
}

#[test]
fn film_says_what_it_is_told_to() {
    let dir = tempfile::tempdir().unwrap();
    // Packets of even and odd length.
    for xmp in ["<x>scene</x>", "<x>scenes</x>"] {
        let texts = [("slabsplat.scene".to_owned(), "volume = \"ä\"".to_owned())];
        let metadata = Metadata::new(texts, Some(xmp.to_owned()));
        for format in [FilmFormat::WebP, FilmFormat::Apng, FilmFormat::PngSequence] {
            let path = dir.path().join(format!("a.{}", format.name()));
            let film = FilmWriter::begin_anew(&path, format, desc(false), "test").unwrap();
            let render = |idx| {
                let frame = FilmFrame::from(frame(idx, 1.0));
                Ok::<_, FilmError>(match format {
                    FilmFormat::PngSequence => frame.metadata(metadata.clone()),
                    _ => frame,
                })
            };
            film.metadata(metadata.clone()).make(render, |_| ()).unwrap();
            let (path, frames) = match format {
                FilmFormat::PngSequence => (path.join("frame_00002.png"), 1),
                _ => (path.clone(), frames_of(&path, format).len()),
            };
            let file = BufReader::new(File::open(&path).unwrap());
            if format == FilmFormat::WebP {
                assert_eq!(frames, N_FRAMES as usize);
                let mut decoder = WebPDecoder::new(file).unwrap();
                assert_eq!(decoder.xmp_metadata().unwrap().unwrap(), xmp.as_bytes());
            } else {
                let reader = png::Decoder::new(file).read_info().unwrap();
                let [text] = reader.info().utf8_text.as_slice() else { panic!("there is one") };
                assert_eq!(text.keyword, "slabsplat.scene");
                assert_eq!(text.get_text().unwrap(), "volume = \"ä\"");
            }
        }
    }
}

#[test]
fn film_of_other_frames_is_not_continued() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.apng");
    let film = FilmWriter::begin(&path, FilmFormat::Apng, desc(false), "scene = 1").unwrap();
    let first_alone = |idx| if idx == 0 { Ok(frame(idx, 1.0)) } else { Err(Failure::from("stop")) };
    film.make(first_alone, |_| ()).unwrap_err();
    let other = FilmWriter::begin(&path, FilmFormat::Apng, desc(false), "scene = 2").unwrap_err();
    let frames = dir.path().join("a.apng.frames");
    let expected = format!(
        "{} has frames of another film, which differs in scene: remove that folder, or begin anew",
        frames.display()
    );
    assert_eq!(other.to_string(), expected);
    FilmWriter::begin_anew(&path, FilmFormat::Apng, desc(false), "scene = 2").unwrap();
}

#[test]
fn frame_of_another_size_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.webp");
    let film = FilmWriter::begin(&path, FilmFormat::WebP, desc(false), "test").unwrap();
    let render = |idx| {
        Ok::<_, FilmError>(if idx == 3 { Image::filled(1, 1, [0.0; 4]) } else { frame(idx, 1.0) })
    };
    let error = film.make(render, |_| ()).unwrap_err().to_string();
    assert_eq!(error, "frame 3 has [1, 1] pixels, and the film [21, 13]");
}
