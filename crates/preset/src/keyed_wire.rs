//! \[SF98\] §2, §3: a wire that moves in time.

use wirework_core::{Closest, Curve, Domain, Keyed, Locator, Wire};

use crate::bounds_frame::BoundsFrame;
use crate::preset::Clock;
use crate::scope::{Mask, Only};

/// Points that move: control points of a curve.
pub(crate) type Points = Keyed<Vec<[f32; 3]>>;

/// A wire that moves in time. Made by reading a preset, so that all its values are good at every time.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyedWire {
    /// The wire at 0 s; at other times what does not move is the same.
    pub(crate) fixed: Wire,
    /// `R`, where it moves.
    pub(crate) reference: Option<Points>,
    /// `W`; none: it follows `R`.
    pub(crate) pose: Option<Points>,
    /// Added to `W`.
    pub(crate) shifts: Vec<Shift>,
    /// The wire's own values; every number is there.
    pub(crate) values: Values,
    pub(crate) locators: Vec<Values>,
    pub(crate) domains: Vec<KeyedDomain>,
    /// The width of [`Closest::Blended`].
    pub(crate) width: Option<Keyed<f32>>,
    pub(crate) only: Option<Only>,
    pub(crate) mask: Option<Mask>,
}

/// A motion that some control points of `W` share.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shift {
    /// Which points, by rising index.
    pub(crate) points: Vec<usize>,
    pub(crate) by: Keyed<[f32; 3]>,
}

/// What moves of a domain curve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct KeyedDomain {
    pub(crate) pose: Option<Points>,
    pub(crate) delta: Keyed<f32>,
    pub(crate) exponent: Keyed<f32>,
}

/// The attributes that both a wire and its locators have. `None`: not carried.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Values {
    pub(crate) radius: Option<Keyed<f32>>,
    pub(crate) scale: Option<Keyed<f32>>,
    pub(crate) rotation: Option<Keyed<f32>>,
    pub(crate) amplitude: Option<Keyed<f32>>,
    pub(crate) twist: Option<Keyed<f32>>,
    pub(crate) angle: Option<Keyed<f32>>,
    pub(crate) direction: Option<Keyed<[f32; 3]>>,
}

/// Names of the attributes, in the order of [`Values::carried`].
pub(crate) const ATTRIBUTES: [&str; 7] =
    ["radius", "scale", "rotation", "amplitude", "twist", "angle", "direction"];

impl Values {
    fn numbers(&self) -> [Option<&Keyed<f32>>; 6] {
        [&self.radius, &self.scale, &self.rotation, &self.amplitude, &self.twist, &self.angle]
            .map(Option::as_ref)
    }

    /// Which of [`ATTRIBUTES`] are here.
    pub(crate) fn carried(&self) -> [bool; 7] {
        let [radius, scale, rotation, amplitude, twist, angle] = self.numbers().map(|n| n.is_some());
        [radius, scale, rotation, amplitude, twist, angle, self.direction.is_some()]
    }

    /// Numbers that are missing are as in `wire`.
    pub(crate) fn or(self, wire: &Wire) -> Self {
        let or = |value: Option<Keyed<f32>>, default| value.or(Some(Keyed::Constant(default)));
        Self {
            radius: or(self.radius, wire.radius),
            scale: or(self.scale, wire.scale),
            rotation: or(self.rotation, wire.rotation),
            amplitude: or(self.amplitude, wire.amplitude),
            twist: or(self.twist, wire.twist),
            angle: or(self.angle, wire.angle),
            direction: self.direction,
        }
    }

    fn time(&self, clock: &mut Clock) {
        self.numbers().into_iter().flatten().for_each(|track| clock.track(track));
        self.direction.iter().for_each(|track| clock.track(track));
    }

    /// Of lengths only the radius is one.
    fn placed(&self, frame: &BoundsFrame) -> Self {
        Self { radius: self.radius.as_ref().map(|radius| frame.lengths(radius)), ..self.clone() }
    }

    /// As a locator at `u`.
    fn locator(&self, u: f32, seconds: f64) -> Locator {
        let now = |value: &Option<Keyed<f32>>| value.as_ref().map(|value| value.at(seconds));
        Locator {
            u,
            radius: now(&self.radius),
            scale: now(&self.scale),
            rotation: now(&self.rotation),
            amplitude: now(&self.amplitude),
            twist: now(&self.twist),
            direction: self.direction.as_ref().map(|direction| direction.at(seconds)),
            angle: now(&self.angle),
        }
    }
}

impl KeyedWire {
    /// `R` at 0 s.
    pub fn reference(&self) -> &Curve {
        &self.fixed.reference
    }

    /// What it may move; none: everything. The effect's own `only` holds besides.
    pub fn only(&self) -> Option<&Only> {
        self.only.as_ref()
    }

    /// Its painted falloff; the effect's own mask is multiplied with it.
    pub fn mask(&self) -> Option<&Mask> {
        self.mask.as_ref()
    }

    /// With [`KeyedWire::fixed`] as it is to be.
    pub(crate) fn settled(mut self) -> Self {
        if let Some(pose) = &self.pose {
            self.fixed.pose = pose.at(0.0);
        }
        self.fixed = self.at(0.0);
        self
    }

    /// The wire at a time in seconds.
    pub fn at(&self, seconds: f64) -> Wire {
        let mut wire = self.fixed.clone();
        self.at_into(seconds, &mut wire);
        wire
    }

    /// Moves a wire that [`KeyedWire::at`] made to another time. What does not move in it stays untouched; a change of its
    /// reference or its domain curves binds it anew.
    pub fn at_into(&self, seconds: f64, wire: &mut Wire) {
        self.curves_into(seconds, wire);
        let now = self.values.locator(0.0, seconds);
        for (new, value) in [
            (now.radius, &mut wire.radius),
            (now.scale, &mut wire.scale),
            (now.rotation, &mut wire.rotation),
            (now.amplitude, &mut wire.amplitude),
            (now.twist, &mut wire.twist),
            (now.angle, &mut wire.angle),
        ] {
            *value = new.unwrap_or(*value);
        }
        wire.direction = now.direction;
        for (keyed, locator) in self.locators.iter().zip(&mut wire.locators) {
            *locator = keyed.locator(locator.u, seconds);
        }
        for (keyed, domain) in self.domains.iter().zip(&mut wire.domains) {
            domain.delta = keyed.delta.at(seconds);
            domain.exponent = keyed.exponent.at(seconds);
        }
        if let Some(width) = &self.width {
            wire.closest = Closest::Blended(width.at(seconds));
        }
    }

    /// `R` at a time in seconds.
    pub(crate) fn reference_at(&self, seconds: f64) -> Curve {
        let mut curve = self.fixed.reference.clone();
        self.reference.iter().for_each(|track| moved(track, seconds, &mut curve));
        curve
    }

    /// `D` of domain `index` at a time in seconds.
    pub(crate) fn domain_at(&self, index: usize, seconds: f64) -> Option<Curve> {
        let mut curve = self.fixed.domains.get(index)?.curve.clone();
        self.domains.get(index)?.pose.iter().for_each(|track| moved(track, seconds, &mut curve));
        Some(curve)
    }

    /// The part of it that is curves.
    fn curves_into(&self, seconds: f64, wire: &mut Wire) {
        if let Some(track) = &self.reference {
            moved(track, seconds, &mut wire.reference);
        }
        match &self.pose {
            Some(pose @ Keyed::Keys(_)) => wire.pose = pose.at(seconds),
            Some(Keyed::Constant(points)) if !self.shifts.is_empty() => points.clone_into(&mut wire.pose),
            None if self.reference.is_some() || !self.shifts.is_empty() => {
                wire.reference.points().clone_into(&mut wire.pose);
            }
            _ => {}
        }
        for shift in &self.shifts {
            let by = shift.by.at(seconds);
            for &index in &shift.points {
                if let Some(point) = wire.pose.get_mut(index) {
                    *point = [0, 1, 2].map(|axis| (point[axis] + by[axis]).clamp(f32::MIN, f32::MAX));
                }
            }
        }
        for (keyed, domain) in self.domains.iter().zip(&mut wire.domains) {
            if let Some(track) = &keyed.pose {
                moved(track, seconds, &mut domain.curve);
            }
        }
    }

    /// Tells a clock every track.
    pub(crate) fn time(&self, clock: &mut Clock) {
        let domain_poses = self.domains.iter().filter_map(|domain| domain.pose.as_ref());
        self.reference.iter().chain(&self.pose).chain(domain_poses).for_each(|track| clock.track(track));
        self.shifts.iter().for_each(|shift| clock.track(&shift.by));
        for values in [&self.values].into_iter().chain(&self.locators) {
            values.time(clock);
        }
        let numbers = self.domains.iter().flat_map(|domain| [&domain.delta, &domain.exponent]);
        numbers.chain(&self.width).for_each(|track| clock.track(track));
    }

    /// Whether the wire leaves the object as it is at all times.
    pub(crate) fn is_still(&self) -> bool {
        let lies = self.lies_on_reference();
        self.rests(|v| &v.amplitude, 0.0)
            || (lies && self.rests(|v| &v.scale, 1.0) && self.rests(|v| &v.twist, 0.0))
    }

    /// Whether an attribute is `rest` all along the wire at all times.
    pub(crate) fn rests(&self, get: fn(&Values) -> &Option<Keyed<f32>>, rest: f32) -> bool {
        [&self.values]
            .into_iter()
            .chain(&self.locators)
            .all(|values| get(values).as_ref().is_none_or(|track| track.values().all(|&value| value == rest)))
    }

    /// Whether `W = R` at all times.
    pub(crate) fn lies_on_reference(&self) -> bool {
        let shifted = self.shifts.iter().any(|shift| shift.by.values().any(|by| *by != [0.0; 3]));
        let follows = match (&self.pose, &self.reference) {
            (None, _) => true,
            (Some(pose), None) => pose.values().all(|points| points == self.fixed.reference.points()),
            // Equal tracks agree at every time, and so do two that never change.
            (Some(pose), Some(reference)) => {
                let first = reference.values().next();
                pose == reference
                    || pose.values().chain(reference.values()).all(|points| Some(points) == first)
            }
        };
        follows && !shifted
    }

    /// The wire with positions and lengths in parts of `frame`.
    pub(crate) fn placed(&self, frame: &BoundsFrame) -> Self {
        let points = |track: &Option<Points>| track.as_ref().map(|track| frame.points(track));
        let domains = self.fixed.domains.iter();
        let fixed = Wire {
            reference: frame.curve(&self.fixed.reference),
            domains: domains.map(|d| Domain { curve: frame.curve(&d.curve), ..d.clone() }).collect(),
            ..self.fixed.clone()
        };
        let pose = fixed.reference.points().to_vec();
        let fixed = Wire { pose, ..fixed };
        let domains = self.domains.iter();
        Self {
            fixed,
            reference: points(&self.reference),
            pose: points(&self.pose),
            shifts: self.shifts.iter().map(|shift| shift.placed(frame)).collect(),
            values: self.values.placed(frame),
            locators: self.locators.iter().map(|values| values.placed(frame)).collect(),
            domains: domains.map(|d| KeyedDomain { pose: points(&d.pose), ..d.clone() }).collect(),
            width: self.width.as_ref().map(|width| frame.lengths(width)),
            only: self.only.clone(),
            mask: self.mask.clone(),
        }
        .settled()
    }
}

impl Shift {
    fn placed(&self, frame: &BoundsFrame) -> Self {
        Self { points: self.points.clone(), by: self.by.map(|by| frame.vector(*by)) }
    }
}

/// Moves the control points of a curve, which are as many as those of the track.
fn moved(track: &Points, seconds: f64, curve: &mut Curve) {
    if let Ok(posed) = curve.posed(track.at(seconds)) {
        *curve = posed;
    }
}
