//! Units in which lengths are shown.

/// A unit, and how many of the world's it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    /// Its symbol; empty where nobody says what lengths are.
    pub(crate) symbol: &'static str,
    pub(crate) in_world: f64,
}

/// Units of length, from the least, and how many millimetres they have.
const METRIC: [Unit; 6] = [
    Unit { symbol: "nm", in_world: 1e-6 },
    Unit { symbol: "µm", in_world: 1e-3 },
    Unit { symbol: "mm", in_world: 1.0 },
    Unit { symbol: "cm", in_world: 10.0 },
    Unit { symbol: "m", in_world: 1e3 },
    Unit { symbol: "km", in_world: 1e6 },
];

const NAMELESS: Unit = Unit { symbol: "", in_world: 1.0 };

impl Unit {
    /// The unit in which people say a length of the world; centimetres from 10 on.
    pub(crate) fn of(length: f64, is_metric: bool) -> Self {
        let suits = |unit: &&Self| {
            let least = if unit.symbol == "cm" { 10.0 } else { 1.0 };
            // A bar of 1 mm is not to be 1000 µm for a rounding error.
            unit.in_world * least <= length * (1.0 + 1e-9)
        };
        match METRIC.iter().rev().find(suits) {
            _ if !is_metric => NAMELESS,
            Some(unit) => *unit,
            None => METRIC[0],
        }
    }

    /// What coordinates along an axis of that length are in: never centimetres, which nobody counts slices
    /// in.
    pub(crate) fn of_axis(length: f64, is_metric: bool) -> Self {
        let unit = Self::of(length, is_metric);
        match METRIC.iter().position(|metric| *metric == unit) {
            Some(3) => METRIC[2],
            // A field of 1.5 mm counts micrometres no more than one of 0.9.
            _ => unit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_is_what_people_say() {
        let check = |length: f64, symbol, axis| {
            assert_eq!(Unit::of(length, true).symbol, symbol, "{length}");
            assert_eq!(Unit::of_axis(length, true).symbol, axis, "{length}");
            assert_eq!(Unit::of(length, false), NAMELESS);
        };
        check(1e-9, "nm", "nm");
        check(2e-5, "nm", "nm");
        check(0.05, "µm", "µm");
        check(1.0, "mm", "mm");
        check(50.0, "mm", "mm");
        check(100.0, "cm", "mm");
        check(200.0, "cm", "mm");
        check(1000.0, "m", "m");
        check(5e6, "km", "km");
        check(0.1 * 0.1 * 0.1, "µm", "µm");
    }
}
