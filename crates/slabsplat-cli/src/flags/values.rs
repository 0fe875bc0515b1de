//! Values of flags: vectors, colours, points of a transfer function, types. Their errors are clap's to
//! print, so they are plain sentences.

use slabsplat::glam::DVec3;
use slabsplat::io::TransferImageFile;
use slabsplat::{Isosurface, Light, Plane, Region, SampleType, TransferBox};

/// Value and opacity, of each point of a transfer function.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OpacityPoints(pub(crate) Vec<(f64, [f64; 1])>);

/// Value and red, green, blue, of each point of a transfer function.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ColorPoints(pub(crate) Vec<(f64, [f64; 3])>);

/// Three numbers, `X,Y,Z`.
pub(crate) fn vector(text: &str) -> Result<DVec3, String> {
    numbers(text).map(DVec3::from_array)
}

/// Two numbers, `X,Y`.
pub(crate) fn pair(text: &str) -> Result<Pair, String> {
    numbers(text).map(Pair)
}

/// Two numbers. A type of its own, because clap takes bare arrays for lists of flags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair(pub(crate) [f64; 2]);

/// The least and the greatest corner of a box, `X0,Y0,Z0,X1,Y1,Z1`.
pub(crate) fn ends(text: &str) -> Result<[DVec3; 2], String> {
    let [x0, y0, z0, x1, y1, z1] = numbers(text)?;
    let ends = [DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1)];
    Region::in_box(ends).map_err(|error| error.to_string())?;
    Ok(ends)
}

/// A plane, `NX,NY,NZ,D`.
pub(crate) fn plane(text: &str) -> Result<Plane, String> {
    let [x, y, z, distance] = numbers(text)?;
    Plane::new(DVec3::new(x, y, z), distance).map_err(|error| error.to_string())
}

/// Three lengths, `X,Y,Z`.
pub(crate) fn spacing(text: &str) -> Result<DVec3, String> {
    let spacing = vector(text)?;
    if spacing.is_finite() && 0.0 < spacing.min_element() {
        return Ok(spacing);
    }
    Err("a spacing is three positive numbers".to_owned())
}

/// Bytes, as `800MiB` or `2GiB`.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    const UNITS: [(&str, u64); 6] = [
        ("KiB", 1 << 10),
        ("MiB", 1 << 20),
        ("GiB", 1 << 30),
        ("TiB", 1 << 40),
        ("MB", 1_000_000),
        ("GB", 1_000_000_000),
    ];
    let parsed = UNITS.iter().find_map(|(unit, size)| {
        let number: f64 = text.strip_suffix(unit)?.trim_end().parse().ok()?;
        let bytes = number * *size as f64;
        (1.0 <= bytes && bytes < 2_f64.powi(63)).then_some(bytes as u64)
    });
    parsed.ok_or_else(|| "memory is a number of MiB or GiB, as 800MiB or 2GiB".to_owned())
}

/// How thick something is, in world units.
pub(crate) fn width(text: &str) -> Result<f64, String> {
    let width = text.parse().ok().filter(|width| 0.0 < *width && *width < f64::INFINITY);
    width.ok_or_else(|| "a width is a number above 0, in world units".to_owned())
}

/// Three counts, `X,Y,Z`.
pub(crate) fn dims(text: &str) -> Result<Dims, String> {
    let parts = split::<3>(text)?;
    let mut dims = [0; 3];
    for (n, part) in dims.iter_mut().zip(parts) {
        *n = part.parse().map_err(|_| format!("{part:?} is not a number of voxels"))?;
    }
    Ok(Dims(dims))
}

/// Voxels along each axis. A type of its own, because clap takes bare arrays for lists of flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Dims(pub(crate) [usize; 3]);

/// `VALUE:OPACITY,VALUE:OPACITY,..`; semicolons part the points too.
pub(crate) fn opacity(text: &str) -> Result<OpacityPoints, String> {
    points(text, &[',', ';']).map(OpacityPoints)
}

/// `VALUE:R,G,B;VALUE:R,G,B;..`.
pub(crate) fn color(text: &str) -> Result<ColorPoints, String> {
    points(text, &[';']).map(ColorPoints)
}

/// `VALUE`, `VALUE:OPACITY` or `VALUE:OPACITY:R,G,B`.
pub(crate) fn isosurface(text: &str) -> Result<Isosurface, String> {
    let mut parts = text.splitn(3, ':');
    let value = number(parts.next().unwrap_or_default())?;
    let opacity = parts.next().map_or(Ok(1.0), number)?;
    let color = parts.next().map(numbers).transpose()?;
    Isosurface::new(value, opacity, color).map_err(|error| error.to_string())
}

/// `V0,V1,G0,G1`, and after colons opacity and `R,G,B`.
pub(crate) fn transfer_box(text: &str) -> Result<TransferBox, String> {
    let mut parts = text.splitn(3, ':');
    let [v0, v1, g0, g1] = numbers(parts.next().unwrap_or_default())?;
    let opacity = parts.next().map_or(Ok(1.0), number)?;
    let color = parts.next().map_or(Ok([1.0; 3]), numbers)?;
    let part = TransferBox::new([v0, v1], [g0, g1]);
    part.and_then(|part| part.opacity(opacity)?.color(color)).map_err(|error| error.to_string())
}

/// `FILE:V0,V1,G0,G1`.
pub(crate) fn transfer_image(text: &str) -> Result<TransferImageFile, String> {
    let (path, ends) = text.rsplit_once(':').ok_or("expected FILE:V0,V1,G0,G1")?;
    let [v0, v1, g0, g1] = numbers(ends)?;
    Ok(TransferImageFile::new(path, [v0, v1], [g0, g1]))
}

/// `headlight`, or a direction towards the light, `X,Y,Z`; and after a colon its colour, `R,G,B`.
pub(crate) fn light(text: &str) -> Result<Light, String> {
    let (source, color) = match text.split_once(':') {
        Some((source, color)) => (source, numbers(color)?),
        None => (text, [1.0; 3]),
    };
    if source == "headlight" {
        return Ok(Light::default().color(color));
    }
    let direction = vector(source).map_err(|error| format!("{error}, or headlight"))?;
    let light = Light::towards(direction).map_err(|error| error.to_string())?;
    Ok(light.color(color))
}

/// Two numbers, `LO:HI`.
pub(crate) fn range_ends(text: &str) -> Result<Ends, String> {
    let (lo, hi) = text.split_once(':').ok_or("expected LO:HI")?;
    Ok(Ends([number(lo)?, number(hi)?]))
}

/// The lower and the upper end of a range. A type of its own, because clap takes bare arrays for lists of
/// flags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ends(pub(crate) [f64; 2]);

fn points<const N: usize>(text: &str, separators: &[char]) -> Result<Vec<(f64, [f64; N])>, String> {
    let point = |part: &str| {
        let (value, results) =
            part.split_once(':').ok_or_else(|| format!("{part:?} is no point VALUE:RESULT"))?;
        Ok((number(value)?, numbers(results)?))
    };
    text.split(separators).filter(|part| !part.trim().is_empty()).map(point).collect()
}

fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let mut numbers = [0.0; N];
    for (n, part) in numbers.iter_mut().zip(split::<N>(text)?) {
        *n = number(part)?;
    }
    Ok(numbers)
}

fn split<const N: usize>(text: &str) -> Result<[&str; N], String> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    <[&str; N]>::try_from(parts)
        .map_err(|parts| format!("expected {N} numbers parted by commas, found {}", parts.len()))
}

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| format!("{text:?} is not a number"))
}

/// The name of a sample type.
pub(crate) fn sample_type(text: &str) -> Result<SampleType, String> {
    text.parse().map_err(|_| format!("choose one of {}", SampleType::NAMES.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_have_units() {
        for (text, expected) in
            [("1KiB", 1024), ("1.5 MiB", 3 << 19), ("2GiB", 2 << 30), ("3GB", 3_000_000_000)]
        {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for text in ["2", "GiB", "-1GiB", "0MiB", "nanGiB", "1e300GiB", "2gib"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn values_parse() {
        assert_eq!(vector("-1, 2.5,3e1"), Ok(DVec3::new(-1.0, 2.5, 30.0)));
        assert_eq!(ends("0,0,0,1,2,3"), Ok([DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)]));
        assert_eq!(plane("0,2,0,-4"), Ok(Plane::new(DVec3::Y, -2.0).unwrap()));
        assert_eq!(range_ends("-5: 2e3"), Ok(Ends([-5.0, 2000.0])));
        assert_eq!(dims("4,5,6"), Ok(Dims([4, 5, 6])));
        assert_eq!(
            opacity("80:0, 255:0.9"),
            Ok(OpacityPoints(vec![(80.0, [0.0]), (255.0, [0.9])]))
        );
        assert_eq!(color("-5:0,0,1;"), Ok(ColorPoints(vec![(-5.0, [0.0, 0.0, 1.0])])));
        assert_eq!(isosurface("-80"), Ok(Isosurface::new(-80.0, 1.0, None).unwrap()));
        let red = Isosurface::new(1.5, 0.25, Some([1.0, 0.0, 0.0])).unwrap();
        assert_eq!(isosurface("1.5: 0.25: 1,0,0"), Ok(red));
        let part = TransferBox::new([0.0, 9.0], [1.0, f64::INFINITY]).unwrap();
        assert_eq!(transfer_box("0,9,1,inf"), Ok(part));
        let part = part.opacity(0.5).and_then(|part| part.color([0.0, 1.0, 0.0])).unwrap();
        assert_eq!(transfer_box("0,9, 1,inf: 0.5: 0,1,0"), Ok(part));
        let image = TransferImageFile::new("C:/a:b.png", [-1.0, 9.0], [0.0, 5.0]);
        assert_eq!(transfer_image("C:/a:b.png:-1,9,0,5"), Ok(image));
        let below = Light::towards(-DVec3::Y).unwrap();
        assert_eq!(light("0,-2,0"), Ok(below));
        assert_eq!(light("0,-2,0:1,0.5,0"), Ok(below.color([1.0, 0.5, 0.0])));
        assert_eq!(light("headlight"), Ok(Light::default()));
        assert_eq!(sample_type("int16"), Ok(SampleType::I16));
    }

    #[test]
    fn values_say_what_is_wrong() {
        let check = |error: Result<(), String>, expected: &str| {
            let error = error.unwrap_err();
            assert!(error.contains(expected), "{error} should contain {expected}");
        };
        check(range_ends("5").map(drop), "expected LO:HI");
        check(range_ends("5:x").map(drop), "\"x\" is not a number");
        check(vector("1,2").map(drop), "expected 3 numbers parted by commas, found 2");
        check(vector("1,x,3").map(drop), "\"x\" is not a number");
        check(dims("4,-5,6").map(drop), "\"-5\" is not a number of voxels");
        check(opacity("80").map(drop), "\"80\" is no point");
        check(color("0:1,1").map(drop), "expected 3 numbers");
        check(ends("0,0,0,1,-1,1").map(drop), "from its least to its greatest corner");
        check(plane("0,0,0,1").map(drop), "other than zero");
        check(isosurface("").map(drop), "\"\" is not a number");
        check(isosurface("inf").map(drop), "needs a finite value, not inf");
        check(isosurface("80:1.5").map(drop), "between 0 and 1, not at 1.5");
        check(isosurface("80:1:1,0").map(drop), "expected 3 numbers");
        check(transfer_box("0,9,1").map(drop), "expected 4 numbers");
        check(transfer_box("9,0,1,2").map(drop), "values go from the least to the largest");
        check(transfer_box("0,9,1,2:7").map(drop), "between 0 and 1, not at 7");
        check(transfer_image("a.png").map(drop), "expected FILE:V0,V1,G0,G1");
        check(light("sun").map(drop), "or headlight");
        check(light("0,0,0").map(drop), "other than zero");
        check(sample_type("int12").map(drop), "uint8, int8, uint16");
    }
}
