//! What of a wire moves in time, for those who play it by its control points alone.

use wirework_core::{Interpolate, Keyed};

use crate::keyed_wire::{ATTRIBUTES, KeyedWire, Values};

/// When the pose of a wire has keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseKeys {
    /// Seconds, rising; none where the pose does not move.
    pub times: Vec<f64>,
    /// Whether control points run along straight lines between them, at an even speed.
    pub linear: bool,
}

impl KeyedWire {
    /// The first field, other than the pose, that changes in time, as `locators[1].radius`; none where only the pose does.
    pub fn unsteady(&self) -> Option<String> {
        let moving = |values: &Values| values.moving().map(str::to_owned);
        if let Some(field) = moving(&self.values) {
            return Some(field);
        }
        let located = self.locators.iter().enumerate();
        let located = located.filter_map(|(i, values)| Some(format!("locators[{i}].{}", moving(values)?)));
        let bounded = self.domains.iter().enumerate().filter_map(|(i, domain)| {
            let pose = domain.pose.as_ref().is_some_and(changes).then_some("pose");
            let delta = changes(&domain.delta).then_some("delta");
            let exponent = changes(&domain.exponent).then_some("exponent");
            Some(format!("domains[{i}].{}", pose.or(delta).or(exponent)?))
        });
        let reference = self.reference.as_ref().is_some_and(changes).then(|| "reference".to_owned());
        let closest = self.width.as_ref().is_some_and(changes).then(|| "closest".to_owned());
        located.chain(bounded).chain(reference).chain(closest).next()
    }

    /// Whether at all times all control points are moved alike, to the last bit of what was typed: then `W′ = R′`, and the wire
    /// turns nothing, whatever its `rotation`. Only for wires whose reference stays.
    pub fn translates(&self) -> bool {
        let rest = self.fixed.reference.points();
        let step = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|k| f64::from(b[k]) - f64::from(a[k]));
        let alike = |pose: &Vec<[f32; 3]>| {
            let mut steps = rest.iter().zip(pose).map(step);
            let first = steps.next();
            steps.all(|step| Some(step) == first)
        };
        let whole = |points: &[usize]| points.len() == rest.len();
        self.pose.as_ref().is_none_or(|pose| pose.values().all(alike))
            && self
                .shifts
                .iter()
                .all(|shift| whole(&shift.points) || shift.by.values().all(|by| *by == [0.0; 3]))
    }

    /// When the pose has keys.
    pub fn pose_keys(&self) -> PoseKeys {
        let poses = self.pose.iter().map(|track| (track.times().collect::<Vec<f64>>(), track.eased()));
        let shifts = self.shifts.iter().map(|shift| (shift.by.times().collect(), shift.by.eased()));
        let mut out = PoseKeys { times: Vec::new(), linear: true };
        for (times, eased) in poses.chain(shifts) {
            out.times.extend(times);
            out.linear &= !eased;
        }
        out.times.sort_by(f64::total_cmp);
        out.times.dedup();
        out
    }
}

impl Values {
    /// The first of [`ATTRIBUTES`] that changes in time.
    fn moving(&self) -> Option<&'static str> {
        let Self { radius, scale, rotation, amplitude, twist, angle, direction } = self;
        let number = |track: &Option<Keyed<f32>>| track.as_ref().is_some_and(changes);
        let directed = direction.as_ref().is_some_and(changes);
        let [r, s, t, a, w, g] = [radius, scale, rotation, amplitude, twist, angle].map(number);
        ATTRIBUTES
            .into_iter()
            .zip([r, s, t, a, w, g, directed])
            .find(|(_, moves)| *moves)
            .map(|(name, _)| name)
    }
}

/// Whether a track has two values.
fn changes<T: Interpolate + PartialEq>(track: &Keyed<T>) -> bool {
    let mut values = track.values();
    let first = values.next();
    values.any(|value| Some(value) != first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Action, Limits, parse};

    fn wires(text: &str) -> Vec<KeyedWire> {
        let preset = parse(format!("Deform(wires: [{text}])").as_bytes(), &Limits::default()).unwrap().preset;
        let Action::Deform(deform) = &preset.effects[0].action else { panic!() };
        deform.wires.clone()
    }

    fn wire(fields: &str) -> KeyedWire {
        wires(&format!("Wire(curve: Polyline([(0, 0, 0), (1, 0, 0)]), {fields})")).remove(0)
    }

    #[test]
    fn what_moves_is_named() {
        for (fields, unsteady) in [
            ("pose: Keys([(0, [(0, 0, 0), (1, 0, 0)]), (1, [(0, 1, 0), (1, 2, 0)])]), twist: 20", None),
            ("radius: Keys([(0, 1), (2, 1)]), scale: 2", None),
            ("radius: Keys([(0, 1), (2, 1.5)])", Some("radius")),
            ("amplitude: Ease([(0, 1), (2, 0)])", Some("amplitude")),
            ("direction: Keys([(0, (0, 1, 0)), (1, (0, 0, 1))])", Some("direction")),
            (
                "locators: [(u: 0, scale: 2), (u: 1, radius: Keys([(0, 1), (1, 2)]))]",
                Some("locators[1].radius"),
            ),
            (
                "reference: Keys([(0, [(0, 0, 0), (1, 0, 0)]), (1, [(0, 1, 0), (1, 2, 0)])])",
                Some("reference"),
            ),
            ("closest: Blended(Keys([(0, 1), (1, 2)]))", Some("closest")),
            (
                "domains: [(curve: Polyline([(0, 1, 0), (1, 1, 0)]), delta: Keys([(0, 0), (1, 0.5)]))]",
                Some("domains[0].delta"),
            ),
        ] {
            assert_eq!(wire(fields).unsteady().as_deref(), unsteady, "{fields}");
        }
    }

    #[test]
    fn what_moves_alike_translates() {
        assert!(wire("radius: 2").translates());
        assert!(
            wire("pose: Ease([(0, [(0, 0, 0), (1, 0, 0)]), (1, [(0, 0.5, 0), (1, 0.5, 0)])])").translates()
        );
        assert!(
            !wire("pose: Keys([(0, [(0, 0, 0), (1, 0, 0)]), (1, [(0, 0.5, 0), (1, 0.6, 0)])])").translates()
        );
        let net = |moves: &str| {
            wires(&format!("WireLattice(min: (0, 0, 0), max: (1, 1, 1), lines: (2, 2, 2), moves: [{moves}])"))
        };
        let by = "by: Keys([(0, (0, 0, 0)), (1, (0, 1, 0))])";
        let all = net(&format!("Move({by})"));
        assert!(all.iter().all(KeyedWire::translates), "{all:?}");
        let face = net(&format!("Move(x: 1, {by})"));
        assert_eq!(face.iter().filter(|wire| !wire.translates()).count(), 4, "those along x");
    }

    #[test]
    fn keys_of_a_pose() {
        let keys = |name: &str| {
            let text =
                format!("pose: {name}([(0.5, [(0, 0, 0), (1, 0, 0)]), (1, [(0, 0.5, 0), (1, 0.5, 0)])])");
            wire(&text).pose_keys()
        };
        assert_eq!(keys("Keys"), PoseKeys { times: vec![0.5, 1.0], linear: true });
        assert_eq!(keys("Ease"), PoseKeys { times: vec![0.5, 1.0], linear: false });
        assert_eq!(wire("radius: 2").pose_keys(), PoseKeys { times: Vec::new(), linear: true });
    }
}
