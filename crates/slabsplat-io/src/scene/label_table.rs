//! Colours of labels, as programs that make labels write them down.
//!
//! ```text
//! FreeSurfer, 3D Slicer   17  Left-Hippocampus  220 216 20 0
//! ITK-SNAP                17  220 216 20  1 1 1  "Left hippocampus"
//! BIDS (dseg.tsv)         index⇥name⇥color, and a row for each label: 17⇥Left hippocampus⇥#dcd814
//! ```
//!
//! Read: labels, their colours, and opacities where the file has any; names are not. Sources:
//! <https://surfer.nmr.mgh.harvard.edu/fswiki/FsTutorial/AnatomicalROI/FreeSurferColorLUT>,
//! <http://www.itksnap.org/pmwiki/pmwiki.php?n=Documentation.TutorialSectionAdvancedSegmentation>,
//! <https://bids-specification.readthedocs.io/en/stable/derivatives/imaging.html#segmentations>.

use std::collections::BTreeMap;
use std::path::Path;

use slabsplat_core::LabelStyle;

use crate::{IoError, text};

/// A row of a table.
struct Row {
    label: i64,
    /// 0 … 1.
    color: [f64; 3],
    /// 0 … 1, if the table says it.
    opacity: Option<f64>,
}

/// Reads the colours of labels from a table of FreeSurfer, 3D Slicer (`.ctbl`), ITK-SNAP, or BIDS (`.tsv`).
///
/// FreeSurfer's last column is a transparency that is always 0, Slicer's an opacity: where it is 0 in all
/// rows it is not one.
///
/// # Errors
/// If the file cannot be read, or a line of it is no row of such a table.
pub(crate) fn read_label_table(path: &Path) -> Result<BTreeMap<i64, LabelStyle>, IoError> {
    let text = text::read(path)?;
    let malformed = |(line, what): (usize, &str)| {
        IoError::malformed(path, format!("line {}: {what}", line + 1))
    };
    let mut lines = lines_of(&text).peekable();
    let rows = match lines.peek().and_then(|(_, line)| BidsColumns::of_header(line)) {
        Some(columns) => lines
            .skip(1)
            .map(|(idx, line)| {
                columns.row(line).ok_or((idx, "not a label and a colour as #rrggbb"))
            })
            .collect::<Result<Vec<_>, _>>(),
        None => lines
            .map(|(idx, line)| {
                row(line).ok_or((idx, "not a label, its name and red, green and blue"))
            })
            .collect(),
    };
    let rows = rows.map_err(malformed)?;
    if rows.is_empty() {
        return Err(IoError::malformed(path, "no label has a colour in it"));
    }
    let has_opacities = rows.iter().any(|row| row.opacity.is_some_and(|opacity| 0.0 < opacity));
    let styles = rows.into_iter().map(|Row { label, color, opacity }| {
        let opacity = opacity.filter(|_| has_opacities).unwrap_or(1.0);
        (label, LabelStyle::default().color(color).opacity(opacity))
    });
    Ok(styles.collect())
}

/// Lines that say something, counted from 0.
fn lines_of(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim).enumerate();
    lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

/// Of the tables without a header.
fn row(line: &str) -> Option<Row> {
    let mut words = line.split_whitespace();
    let label = words.next()?.parse().ok()?;
    let rest: Vec<&str> = words.collect();
    match rest.as_slice() {
        // ITK-SNAP's names are quoted, and all before them is numbers.
        [r, g, b, opacity, visible, _, name, ..] if name.starts_with('"') => {
            let opacity: f64 = opacity.parse().ok()?;
            let is_visible = *visible != "0";
            let opacity = Some(if is_visible { opacity.clamp(0.0, 1.0) } else { 0.0 });
            Some(Row { label, color: color([r, g, b])?, opacity })
        }
        [_, r, g, b] => Some(Row { label, color: color([r, g, b])?, opacity: None }),
        [_, r, g, b, opacity] => {
            let opacity: u8 = opacity.parse().ok()?;
            Some(Row { label, color: color([r, g, b])?, opacity: Some(share(opacity)) })
        }
        _ => None,
    }
}

fn color(channels: [&&str; 3]) -> Option<[f64; 3]> {
    let [r, g, b] = channels.map(|channel| channel.parse().ok().map(share));
    Some([r?, g?, b?])
}

fn share(byte: u8) -> f64 {
    f64::from(byte) / 255.0
}

/// Where a table with a header has what.
struct BidsColumns {
    index: usize,
    color: usize,
}

impl BidsColumns {
    fn of_header(line: &str) -> Option<Self> {
        let column = |name| line.split('\t').position(|column| column == name);
        Some(Self { index: column("index")?, color: column("color")? })
    }

    fn row(&self, line: &str) -> Option<Row> {
        let column = |idx| line.split('\t').nth(idx).map(str::trim);
        let label = column(self.index)?.parse().ok()?;
        let number = u32::from_str_radix(hex(column(self.color)?)?, 16).ok()?;
        let [_, r, g, b] = number.to_be_bytes();
        Some(Row { label, color: [r, g, b].map(share), opacity: None })
    }
}

/// The six digits of a colour.
fn hex(color: &str) -> Option<&str> {
    color
        .strip_prefix('#')
        .filter(|digits| digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<BTreeMap<i64, LabelStyle>, IoError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("labels.txt");
        std::fs::write(&path, text).unwrap();
        read_label_table(&path)
    }

    fn check(text: &str, expected: &[(i64, [u8; 3], f64)]) {
        let table = read(text).unwrap();
        assert_eq!(table.len(), expected.len(), "{text}");
        for (label, color, opacity) in expected {
            let style = &table[label];
            assert_eq!(style.color, Some(color.map(share)), "{text}");
            assert!((style.opacity - opacity).abs() < 1e-12, "{text}");
        }
    }

    #[test]
    fn label_tables_of_other_programs() {
        let freesurfer = "#$Id: FreeSurferColorLUT.txt\n#No. Label Name: R G B A\n\n0   Unknown   0   0   \
                          0   0\n17  Left-Hippocampus  220 216 20  0\r\n";
        check(freesurfer, &[(0, [0; 3], 1.0), (17, [220, 216, 20], 1.0)]);
        let slicer =
            "# Color table file\n0 Background 0 0 0 0\n2 bone 241 214 145 255\n3 fat 1 2 3 51";
        check(slicer, &[(0, [0; 3], 0.0), (2, [241, 214, 145], 1.0), (3, [1, 2, 3], 0.2)]);
        let itk_snap = "    0     0    0    0        0  0  0    \"Clear Label\"\n    1   255    0    0      \
                        0.5  1  1    \"Label 1\"\n 5 1 2 3 1 0 1 \"hidden\"\n";
        check(itk_snap, &[(0, [0; 3], 0.0), (1, [255, 0, 0], 0.5), (5, [1, 2, 3], 0.0)]);
        let bids = "index\tname\tcolor\n1\tGray Matter\t#ff53bb\n2\tWhite Matter\t#2F8F1A\n";
        check(bids, &[(1, [0xff, 0x53, 0xbb], 1.0), (2, [0x2f, 0x8f, 0x1a], 1.0)]);
    }

    #[test]
    fn label_tables_name_the_line_that_is_none() {
        for (text, expected) in [
            ("# nothing\n", "no label has a colour"),
            ("1 a 0 0 0 0\n\nseven b 1 1 1 0\n", "line 3: not a label"),
            ("1 a 0 0 300 0\n", "line 1: not a label"),
            ("1 a b c 0 0 0 0\n", "line 1: not a label"),
            ("index\tcolor\n1\t#12345\n", "line 2: not a label and a colour"),
            ("index\tcolor\n1\t#1234é6\n", "line 2: not a label and a colour"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
