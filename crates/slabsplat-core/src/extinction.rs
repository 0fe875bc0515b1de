//! Opacity as extinction: what `extinction` sums over a sheet (SPEC §3).

/// Opacity from which on extinction stays what it is: at 1 it would be infinite.
pub const MAX_OPACITY: f64 = 1.0 - 1e-6;

/// `μ = −ln(1 − α)` of an opacity, 0 to 1; at most that of [`MAX_OPACITY`], 13.8.
///
/// ```
/// assert_eq!(slabsplat_core::extinction(0.0), 0.0);
/// assert!((slabsplat_core::extinction(0.5) - 0.5_f64.ln().abs()).abs() < 1e-15);
/// assert!(slabsplat_core::extinction(1.0) < 13.82);
/// ```
pub fn extinction(opacity: f64) -> f64 {
    -(-opacity.min(MAX_OPACITY)).ln_1p()
}
