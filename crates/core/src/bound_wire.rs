//! One wire's part of a binding: its curve prepared, the feet of all points, the runs made of them.

use std::sync::Arc;

use crate::arclength::ArcLength;
use crate::cells::Cells;
use crate::closest::Pieces;
use crate::domain::DomainCurve;
use crate::frame::Frame;
use crate::mask::KeptMask;
use crate::runs::{Bound, Runs};
use crate::search::{Found, Sought};
use crate::spans::Spans;
use crate::tiles::Tiles;
use crate::{Bounded, Closest, Curve, Domain, Wire};

/// Stands for a reach that nothing was sought in yet.
pub(crate) const UNBOUND: f32 = -1.0;

/// One wire's part of a binding.
#[derive(Clone, Debug)]
pub(crate) struct BoundWire {
    /// The state the points were bound in.
    pub(crate) wire: Wire,
    /// Feet were sought up to this distance; [`UNBOUND`] before.
    pub(crate) reach: f32,
    /// The group it was in before it was bound anew.
    pub(crate) left: Option<u32>,
    /// Whether its feet were found since the groups were last sorted.
    pub(crate) found_anew: bool,
    /// What multiplies its influence.
    pub(crate) mask: Option<Arc<KeptMask>>,
    pub(crate) spans: Spans,
    pub(crate) pieces: Pieces,
    pub(crate) domains: Vec<DomainCurve>,
    pub(crate) lengths: ArcLength,
    pub(crate) cells: Cells,
    pub(crate) runs: Runs,
    /// Kept only in a group, where the nearest wire is chosen again when one of them moves.
    pub(crate) found: Found,
    pub(crate) frame: Frame,
}

impl BoundWire {
    /// The wire prepared; its feet are still to be found.
    pub(crate) fn new(wire: &Wire, mask: Option<Arc<KeptMask>>) -> Self {
        let spans = Spans::new(&wire.reference);
        let domain = |d: &Domain| DomainCurve::new(&d.curve, d.bounds == Bounded::Influence);
        Self {
            lengths: ArcLength::new(&spans),
            pieces: Pieces::new(&spans, width(wire)),
            cells: Cells::new(wire, &spans),
            domains: wire.domains.iter().map(domain).collect(),
            wire: wire.clone(),
            reach: UNBOUND,
            left: None,
            found_anew: false,
            mask,
            runs: Runs::default(),
            found: Found::default(),
            frame: Frame::default(),
            spans,
        }
    }

    /// Takes another reference of the same kind for the one that points were bound to. Another kind of curve is left to be bound anew.
    pub(crate) fn carry(&mut self, reference: &Curve) {
        let own = &self.wire.reference;
        let alike = own.kind() == reference.kind()
            && own.closed() == reference.closed()
            && own.points().len() == reference.points().len();
        if !alike || own == reference {
            return;
        }
        self.spans = Spans::new(reference);
        self.lengths = ArcLength::new(&self.spans);
        self.pieces = Pieces::new(&self.spans, width(&self.wire));
        self.wire.reference.clone_from(reference);
    }

    /// Finds the feet of all points up to `reach`, and makes runs of them; in a group that is left to the binding.
    pub(crate) fn find(&mut self, reach: f32, tiles: &Tiles) {
        self.reach = reach;
        if self.wire.group.is_some() {
            self.found = self.bound().sought.everywhere(tiles);
        } else {
            self.runs = Runs::bind(self.bound(), tiles);
        }
    }

    /// How far its domain curves may carry its influence.
    pub(crate) fn domain_reach(&self) -> f32 {
        self.domains.iter().map(|domain| domain.reach(&self.pieces)).fold(0.0, f64::max) as f32
    }

    pub(crate) fn bound(&self) -> Bound<'_> {
        Bound {
            wire: &self.wire,
            cells: &self.cells,
            sought: Sought {
                spans: &self.spans,
                pieces: &self.pieces,
                domains: &self.domains,
                reach: f64::from(self.reach),
            },
            mask: self.mask.as_deref(),
        }
    }
}

/// How much farther than the least feet may be that count.
fn width(wire: &Wire) -> f64 {
    if let Closest::Blended(width) = wire.closest { f64::from(width) } else { 0.0 }
}

/// Whether two wires have the same feet for all points, and the same standing to domain curves.
pub(crate) fn same_places(a: &Wire, b: &Wire) -> bool {
    let locators = a.locators.iter().map(|l| l.u).eq(b.locators.iter().map(|l| l.u));
    let domains =
        a.domains.iter().map(|d| (&d.curve, d.bounds)).eq(b.domains.iter().map(|d| (&d.curve, d.bounds)));
    a.reference == b.reference && a.closest == b.closest && a.group == b.group && locators && domains
}
