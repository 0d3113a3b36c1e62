//! When joints get keys: at the times that are asked for, and between them where the straight way is off.

/// How often the way between two times is parted at most. A jump is approached so closely; and what needs more than some 70 keys there, as a
/// frame of a second may, is farther off than it is to be.
const PARTINGS: usize = 9;

/// Where: not in the middle, where ways that ease in and out alike are on the straight one.
pub(super) const PART: f64 = 0.382;

/// Looks at `times` and, where `off` of what is at [`PART`] of the way between two of them is more than `tolerance`, there too, and so on in the
/// parts. Gives `take` what it has seen, in the order of time; `look` also gets the number of the time that it is at or behind.
pub(super) fn straightened<S, E>(
    times: &[f64],
    tolerance: f64,
    look: &mut impl FnMut(usize, f64) -> Result<S, E>,
    off: &impl Fn(&S, (&S, &S)) -> f64,
    take: &mut impl FnMut(f64, &S) -> Result<(), E>,
) -> Result<(), E> {
    let mut before: Option<(f64, S)> = None;
    for (frame, &time) in times.iter().enumerate() {
        let now = look(frame, time)?;
        if let Some((from, a)) = &before {
            let mut between = Between { frame: frame - 1, tolerance, look, off, take };
            between.parted((*from, a), (time, &now), PARTINGS)?;
        }
        take(time, &now)?;
        before = Some((time, now));
    }
    Ok(())
}

struct Between<'a, L, O, T> {
    frame: usize,
    tolerance: f64,
    look: &'a mut L,
    off: &'a O,
    take: &'a mut T,
}

impl<L, O, T> Between<'_, L, O, T> {
    fn parted<S, E>(&mut self, a: (f64, &S), b: (f64, &S), left: usize) -> Result<(), E>
    where
        L: FnMut(usize, f64) -> Result<S, E>,
        O: Fn(&S, (&S, &S)) -> f64,
        T: FnMut(f64, &S) -> Result<(), E>,
    {
        let time = a.0 + PART * (b.0 - a.0);
        // Files keep times as 32-bit floats.
        let [start, between, end] = [a.0, time, b.0].map(|time| time as f32);
        if left == 0 || between <= start || end <= between {
            return Ok(());
        }
        let middle = (self.look)(self.frame, time)?;
        if (self.off)(&middle, (a.1, b.1)) <= self.tolerance {
            return Ok(());
        }
        self.parted(a, (time, &middle), left - 1)?;
        (self.take)(time, &middle)?;
        self.parted((time, &middle), b, left - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_come_where_the_way_bends() {
        let times = [0.0, 1.0, 2.0, 3.0, 4.0];
        // A corner at 1.25 s, a parabola from 2 to 3 s, and then one that eases in and out.
        let way = |t: f64| {
            let (bend, ease) = ((t.min(3.0) - 2.0).max(0.0), (t - 3.0).max(0.0));
            (t - 1.25).max(0.0) + 0.4 * bend * bend + ease * ease * (3.0 - 2.0 * ease)
        };
        let mut keys: Vec<(f64, f64)> = Vec::new();
        let mut look = |frame: usize, t: f64| {
            assert!((times[frame]..times[frame] + 1.0).contains(&t), "{t} is behind {frame}");
            Ok::<f64, ()>(way(t))
        };
        let off = |middle: &f64, (a, b): (&f64, &f64)| (a + PART * (b - a) - middle).abs();
        let mut take = |t: f64, value: &f64| {
            keys.push((t, *value));
            Ok(())
        };
        straightened(&times, 0.01, &mut look, &off, &mut take).unwrap();
        let at: Vec<f64> = keys.iter().map(|(t, _)| *t).collect();
        assert!(times.iter().all(|time| at.contains(time)) && at.is_sorted());
        assert_eq!(at.iter().filter(|key| **key < 1.0).count(), 1, "what is straight needs none");
        assert!((14..24).contains(&at.len()), "{at:?}");
        for k in 0..=400 {
            let t = f64::from(k) / 100.0;
            let after = at.partition_point(|key| *key <= t).clamp(1, at.len() - 1);
            let ((t0, a), (t1, b)) = (keys[after - 1], keys[after]);
            // A corner may lie where the look told least of it.
            let most = if (1.0..2.0).contains(&t) { 0.01 / PART } else { 0.011 };
            assert!((a + (b - a) * (t - t0) / (t1 - t0) - way(t)).abs() < most, "{t}");
        }
    }
}
