//! Angles are written in degrees, and must come back as the radians that they were, to the last bit.

/// Degrees whose [`to_radians`](f64::to_radians) is just that, if there are any: of every ten angles one lies
/// between the radians of two neighbouring numbers of degrees.
pub fn exact_degrees(radians: f64) -> Option<f64> {
    let nearest = radians.to_degrees();
    let candidates = [
        nearest.round(),
        nearest,
        nearest.next_up(),
        nearest.next_down(),
        nearest.next_up().next_up(),
        nearest.next_down().next_down(),
    ];
    candidates.into_iter().find(|degrees| degrees.to_radians() == radians)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angle_in_degrees_is_exact_or_none() {
        for degrees in [0.1, 1.0, 20.0, 30.0, 45.5, 60.0, 90.0, 179.9] {
            let radians = f64::to_radians(degrees);
            assert_eq!(exact_degrees(radians).map(f64::to_radians), Some(radians), "{degrees}");
        }
        assert_eq!(exact_degrees(30_f64.to_radians()), Some(30.0));
        let mut radians = 0.7_f64;
        let n_missed = (0..1000).filter(|_| {
            radians = radians.next_up();
            exact_degrees(radians).is_none_or(|degrees| degrees.to_radians() != radians)
        });
        assert!((1..300).contains(&n_missed.count()), "some angles have no degrees, but few");
    }
}
