//! \[SF98\] §3.2 as a preset: `Domain(curve: .., delta: .., exponent: .., bounds: Influence)`.

use glam::{DVec3, Vec3};
use wirework_core::{Bounded, Curve, Domain, Keyed};
use wirework_surface::Bounds;

use crate::curve::curve;
use crate::keyed_wire::{KeyedDomain, KeyedWire};
use crate::moments::{key_nodes, moments};
use crate::read::{Fields, Reader, Within};
use crate::tree::{Body, Node};

/// The last of the points of a domain curve that are looked at: as many as find a curve that was copied from the reference, or
/// that begins, ends or crosses on it.
const LAST: usize = 64;

/// A domain curve is on the reference where it is nearer than this part of the reference's extent.
const ON: f64 = 1e-6;

/// Steps of the search for the place where a domain curve comes nearest: 0.618³² is 2e-7 of the way between four samples.
const STEPS: usize = 32;

/// Reads a list of domain curves.
pub(crate) fn domains(reader: &mut Reader<'_>, node: &Node) -> Option<Vec<(Domain, KeyedDomain)>> {
    let items = reader.list(node, "a list of domain curves `[Domain(curve: .., ..), ..]`")?;
    reader.each(items, domain)
}

fn domain(reader: &mut Reader<'_>, node: &Node) -> Option<(Domain, KeyedDomain)> {
    let mut fields = reader.fields(node, "Domain")?;
    let curve = reader.required(&mut fields, "curve", curve);
    let count = curve.as_ref().map(|curve| curve.points().len());
    let pose =
        reader.optional(&mut fields, "pose", |reader, node| reader.keyed_points(node, "a pose", count));
    let delta = reader.field(&mut fields, "delta", Keyed::Constant(0.0), |reader, node| {
        reader.keyed_number(node, Within::BelowOne)
    });
    let exponent = reader.field(&mut fields, "exponent", Keyed::Constant(1.0), |reader, node| {
        reader.keyed_number(node, Within::Finite)
    });
    let bounds = reader.field(&mut fields, "bounds", Bounded::Influence, |reader, node| {
        let names = [
            ("Influence", Bounded::Influence),
            ("Scale", Bounded::Scale),
            ("Rotation", Bounded::Rotation),
            ("Amplitude", Bounded::Amplitude),
            ("Twist", Bounded::Twist),
        ];
        reader.choice(node, "value of `bounds`", &names)
    });
    reader.finish(fields);
    let domain = Domain { bounds, ..Domain::new(curve?) };
    Some((domain, KeyedDomain { pose, delta, exponent }))
}

/// Domain curves of attributes that do nothing on this wire.
pub(crate) fn lint_bounds(reader: &mut Reader<'_>, fields: &Fields<'_>, wire: &KeyedWire) {
    let Some(Node { body: Body::List(items), .. }) = fields.again("domains") else { return };
    for (index, (item, domain)) in items.iter().zip(&wire.fixed.domains).enumerate() {
        let why = match domain.bounds {
            Bounded::Scale if wire.rests(|v| &v.scale, 1.0) => "the wire's `scale` is 1",
            Bounded::Twist if wire.rests(|v| &v.twist, 0.0) => "the wire's `twist` is 0",
            Bounded::Rotation if wire.rests(|v| &v.rotation, 0.0) => "the wire's `rotation` is 0",
            Bounded::Rotation if wire.lies_on_reference() => {
                "the wire's pose is its curve, so nothing turns with it"
            }
            _ => continue,
        };
        let Some(bounds) = item.field("bounds") else { continue };
        reader.within("domains", |reader| {
            reader.within(format!("[{index}]"), |reader| {
                reader.within("bounds", |reader| {
                    reader.warn(&bounds.span, format!("this domain curve bounds nothing: {why}"));
                });
            });
        });
    }
}

/// Refuses domain curves that lie on the reference at all times; a warning where one does at some time, or touches it. None where
/// the reader has looked at enough.
pub(crate) fn check_domains(reader: &mut Reader<'_>, fields: &Fields<'_>, wire: &KeyedWire) -> Option<()> {
    let Some(Node { body: Body::List(items), .. }) = fields.again("domains") else { return Some(()) };
    for (index, (item, keyed)) in items.iter().zip(&wire.domains).enumerate() {
        // The field that says where the curve lies.
        let key = if keyed.pose.is_some() { "pose" } else { "curve" };
        let value = item.field(key)?;
        let mut meetings: Vec<(f64, Meeting)> = Vec::new();
        for seconds in moments(reader, [&wire.reference, &keyed.pose])? {
            let (domain, reference) = (wire.domain_at(index, seconds)?, wire.reference_at(seconds));
            meetings.push((seconds, meeting(reader, &domain, &reference)?));
        }
        reader.within("domains", |reader| {
            reader.within(format!("[{index}]"), |reader| {
                reader.within(key, |reader| judge(reader, value, &meetings));
            });
        });
    }
    Some(())
}

fn judge(reader: &mut Reader<'_>, node: &Node, meetings: &[(f64, Meeting)]) {
    if meetings.iter().all(|(_, meeting)| *meeting == Meeting::Lies) {
        let message = "a domain curve lies beside the wire's reference; this one lies on it";
        let _: Option<()> = reader.bad(node, message);
        return;
    }
    let met = |wanted| meetings.iter().find(|(_, meeting)| *meeting == wanted).map(|(seconds, _)| *seconds);
    let place = |seconds| key_nodes(node).find(|(time, _)| *time == seconds).map_or(node, |(_, value)| value);
    if let Some(seconds) = met(Meeting::Lies) {
        let message = format!(
            "at {seconds} s this domain curve lies on the wire's reference, and bounds it to nothing"
        );
        reader.warn(&place(seconds).span, message);
    } else if let Some(seconds) = met(Meeting::Touches) {
        let message = "this domain curve touches the wire's reference, and bounds it to nothing there";
        reader.warn(&place(seconds).span, message);
    }
}

/// How a domain curve meets a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meeting {
    Apart,
    Touches,
    Lies,
}

/// None where the reader has looked at enough.
fn meeting(reader: &mut Reader<'_>, domain: &Curve, reference: &Curve) -> Option<Meeting> {
    let near = tolerance(reference);
    let u = |i: usize| i as f64 / LAST as f64;
    let mut distance = |u: f64| {
        reader.look(domain.points().len() + reference.points().len())?;
        reference.closest(domain.point(u as f32)).map(|foot| f64::from(foot.distance))
    };
    // As a rule the first sample tells that it does not lie on the reference.
    let mut first = 0;
    while first <= LAST && distance(u(first))? <= near {
        first += 1;
    }
    match first {
        0 => {}
        _ if first > LAST => return Some(Meeting::Lies),
        _ => return Some(Meeting::Touches),
    }
    let samples: Vec<DVec3> =
        (0..=LAST).map(|i| Vec3::from_array(domain.point(u(i) as f32)).as_dvec3()).collect();
    let between = |i: usize, j: usize| match (samples.get(i), samples.get(j)) {
        (Some(a), Some(b)) => a.distance(*b),
        _ => f64::MAX,
    };
    let (mut i, mut least, mut at) = (0, f64::MAX, 0);
    while i <= LAST {
        let far = distance(u(i))?;
        if far < least {
            (least, at) = (far, i);
        }
        // Of samples about one that is far from the reference none is near it.
        let here = i;
        i += 1;
        while i < LAST && between(here, i) <= 0.5 * far {
            i += 1;
        }
    }
    let (a, b) = (at.saturating_sub(2), (at + 2).min(LAST));
    let reaches = least <= between(a, at) + between(at, b);
    let touches = reaches && nearest(distance, u(a), u(b))? <= near;
    Some(if touches { Meeting::Touches } else { Meeting::Apart })
}

/// The least value of `f` from `a` to `b`, by golden sections.
fn nearest(mut f: impl FnMut(f64) -> Option<f64>, mut a: f64, mut b: f64) -> Option<f64> {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let inner = |a: f64, b: f64| (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
    let (mut x, mut y) = inner(a, b);
    let (mut fx, mut fy) = (f(x)?, f(y)?);
    let mut least = f(a)?.min(f(b)?).min(fx).min(fy);
    for _ in 0..STEPS {
        // One of the two inner points serves again.
        if fx < fy {
            (b, y, fy) = (y, x, fx);
            x = inner(a, b).0;
            fx = f(x)?;
            least = least.min(fx);
        } else {
            (a, x, fx) = (x, y, fy);
            y = inner(a, b).1;
            fy = f(y)?;
            least = least.min(fy);
        }
    }
    Some(least)
}

/// How near is on the curve: a part of its extent, and what float32 rounds off its coordinates.
fn tolerance(curve: &Curve) -> f64 {
    let Some(Bounds { min, max }) = Bounds::of(curve.points()) else { return 0.0 };
    let (min, max) = (Vec3::from_array(min).as_dvec3(), Vec3::from_array(max).as_dvec3());
    let coordinate = min.abs().max(max.abs()).max_element();
    ON * min.distance(max) + 2.0 * f64::from(f32::EPSILON) * coordinate
}
