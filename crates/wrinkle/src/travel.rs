//! How far a travelling fold has come.

use wirework_surface::{Stop, Walker};

/// How far it is from a walker straight ahead to a border; infinite where that is too far to slow down a fold that would have gone
/// `way`, at least 0.
pub(crate) fn room(walker: &Walker<'_>, way: f64, ease: f64) -> f64 {
    match walker.clone().walk(way + ease, |_, _| {}) {
        (_, Stop::Arrived) => f64::INFINITY,
        (walked, _) => walked,
    }
}

/// The way of a fold that would have gone `way`, signed, where there is `room` ahead: it stops at the end of it, and slows down
/// over the last `ease` before.
pub(crate) fn stop(way: f64, room: f64, ease: f64) -> f64 {
    let (ahead, room) = (way.abs(), room.max(0.0));
    let ease = ease.min(room);
    let free = room - ease;
    if ahead <= free || ease <= 0.0 {
        return way.signum() * ahead.min(room);
    }
    // From full speed to rest, the speed falling evenly, in twice the time.
    let x = ((ahead - free) / ease).min(2.0);
    way.signum() * (free + ease * (x - x * x / 4.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stops_smoothly_and_never_beyond_its_room() {
        assert_eq!((stop(0.3, 1.0, 0.2), stop(-0.3, 1.0, 0.2)), (0.3, -0.3));
        assert_eq!((stop(5.0, 1.0, 0.2), stop(-5.0, 1.0, 0.2)), (1.0, -1.0));
        assert_eq!(
            (stop(5.0, 0.0, 0.2), stop(5.0, -1.0, 0.2), stop(5.0, f64::INFINITY, 0.2)),
            (0.0, 0.0, 5.0)
        );
        let (step, mut speed) = (1e-3, 1.0);
        for i in 0..2000 {
            let way = f64::from(i) * step;
            let now = (stop(way + step, 1.0, 0.2) - stop(way, 1.0, 0.2)) / step;
            assert!(
                now <= speed + 1e-9 && speed - now < 0.01 && now >= -1e-12,
                "{now} after {speed} at {way}"
            );
            speed = now;
        }
        assert!(speed.abs() < 1e-9);
    }
}
