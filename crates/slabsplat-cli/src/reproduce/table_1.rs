//! Table 1: two rays that gather different colours from like faces.

use super::Studio;
use super::html::{Cell, paragraph, table};
use super::page::{Claim, Section};
use anyhow::Result;
use slabsplat::kernel::{Gaussian, Kernel};
use slabsplat::paper::table_1::{PRINTED_RAY_1, PRINTED_RAY_2, RayRow, footprint, ray_1, ray_2};

const HEAD: [&str; 10] = [
    "sheet",
    "weight",
    "printed",
    "opacity",
    "printed",
    "premultiplied colour",
    "printed",
    "true colour",
    "printed",
    "",
];

/// Nothing is drawn: the table is arithmetic.
pub(super) fn section(_studio: &mut Studio) -> Result<Section> {
    let (first, second) = (ray_1(footprint), ray_2(footprint));
    let last = second[4];
    let drawn = |r_squared: f64| Gaussian.footprint(r_squared.sqrt());
    let drawn = [ray_1(drawn), ray_2(drawn)[4]];
    let body = [
        paragraph(
            "Both rays meet a face of the cube that turns 45° to the image, and five white footprints each. \
             The first ray’s face is parallel to the sheets: its footprints are added in one sheet. The second \
             ray’s face is not: the same footprints are composited in five sheets. The weights are eq. 3, the \
             colours eqs. 2 and 4.",
        ),
        table("Ray 1", &HEAD, vec![row(&first, &PRINTED_RAY_1)]),
        table(
            "Ray 2",
            &HEAD,
            second.iter().zip(&PRINTED_RAY_2).map(|(ours, printed)| row(ours, printed)).collect(),
        ),
        paragraph(
            "Eq. 3 is printed with base e; the weights of the table, and a sum of 1 over the grid, are those of \
             base 2. In sheet 5 the paper slips: eq. 2 gives 0.2447 + (1 − 0.2447) · 0.446 = 0.5816, it prints \
             0.592, and carries that on to the end. Sheet 4’s colour is 0.0491 by eq. 2 and printed as 0.0483; and \
             of sheet 3 the true colour, 0.0007 over 0.0278, is ten times what is printed.",
        ),
        paragraph(&format!(
            "Pictures are drawn with a kernel that ends at a radius of 2, which takes a little off the weights: \
             ray 1 ends at an opacity of {:.4} and a colour of {:.4}, ray 2 at {:.4} and {:.4}.",
            drawn[0].opacity, drawn[0].color, drawn[1].opacity, drawn[1].color
        )),
    ];
    let claims = vec![
        Claim {
            paper: "ray 1 ends at an opacity of 0.947 and a colour of 0.898",
            found: pair(&first).into(),
            agrees: agrees(&first, &PRINTED_RAY_1),
        },
        Claim {
            paper: "ray 2 ends at an opacity of 0.6912 and a colour of 0.218: much darker",
            found: format!("{}; the paper slips in sheet 5", pair(&last)).into(),
            agrees: agrees(&last, &PRINTED_RAY_2[4]),
        },
    ];
    Ok(Section { id: "table-1", title: "Table 1: two rays", claims, body: body.concat() })
}

fn pair(row: &RayRow) -> String {
    format!("{:.4} and {:.4}", row.opacity, row.color)
}

fn row(ours: &RayRow, printed: &RayRow) -> Vec<Cell> {
    let mut cells: Vec<Cell> = vec![ours.sheet.to_string().into()];
    for (ours, printed) in columns(ours, printed) {
        cells.extend([format!("{ours:.4}").into(), printed.to_string().into()]);
    }
    cells.push(if agrees(ours, printed) { "as printed" } else { "differs" }.into());
    cells
}

fn columns(ours: &RayRow, printed: &RayRow) -> [(f64, f64); 4] {
    [
        (ours.weight, printed.weight),
        (ours.opacity, printed.opacity),
        (ours.color, printed.color),
        (ours.true_color, printed.true_color),
    ]
}

/// Whether opacities and premultiplied colours are those printed. True colours are the quotient of both, of
/// which few digits are left where both are small.
fn agrees(ours: &RayRow, printed: &RayRow) -> bool {
    let [_, opacity, color, _] = columns(ours, printed);
    [opacity, color].into_iter().all(|(ours, printed)| is_as_printed(ours, printed))
}

/// Within a unit of the last digit that is printed, since some are cut off rather than rounded.
fn is_as_printed(ours: f64, printed: f64) -> bool {
    let text = printed.to_string();
    let n_decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    (ours - printed).abs() < 10_f64.powi(-(n_decimals as i32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_1_agrees_to_the_last_digit() {
        assert!(is_as_printed(0.9479, 0.947) && is_as_printed(0.9461, 0.947));
        assert!(!is_as_printed(0.9481, 0.947));
        assert!(is_as_printed(0.00079, 0.0007) && !is_as_printed(0.00081, 0.0007));
    }
}
