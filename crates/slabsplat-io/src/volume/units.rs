//! Units of length, which become millimetres everywhere alike.

/// How many millimetres a unit has, as OME, ImageJ and NRRD name it; `None` for what is no length.
pub(super) fn millimetres(unit: &str) -> Option<f64> {
    match unit {
        "m" | "meter" | "metre" => Some(1e3),
        "cm" => Some(10.0),
        "mm" | "millimeter" | "millimetre" => Some(1.0),
        // The micro sign, the Greek letter, and ImageJ's ways round both.
        "µm" | "μm" | "um" | "micron" | "microns" | "micrometer" | "\\u00B5m" => Some(1e-3),
        "nm" => Some(1e-6),
        "pm" => Some(1e-9),
        "Å" => Some(1e-7),
        "in" | "inch" => Some(25.4),
        _ => None,
    }
}
