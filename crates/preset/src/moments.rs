//! The moments at which what moves is checked: those of its keys.

use crate::keyed_wire::Points;
use crate::read::Reader;
use crate::tree::{Body, Node};

/// The times of all keys of some curves; without keys, 0 s. None where the reader has looked at enough.
pub(crate) fn moments<const N: usize>(
    reader: &mut Reader<'_>,
    tracks: [&Option<Points>; N],
) -> Option<Vec<f64>> {
    let keys = || tracks.iter().copied().flatten().flat_map(Points::times);
    reader.look(keys().count())?;
    let mut times: Vec<f64> = keys().collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    if times.is_empty() {
        times.push(0.0);
    }
    Some(times)
}

/// The keys of a † value as typed: their times and the nodes of their values. Empty for a constant.
pub(crate) fn key_nodes(node: &Node) -> impl Iterator<Item = (f64, &Node)> {
    let keys = match &node.unwrap_some().body {
        Body::Tuple(inner) => match inner.as_slice() {
            [Node { body: Body::List(keys), .. }] => keys.as_slice(),
            _ => &[],
        },
        _ => &[],
    };
    keys.iter().filter_map(|key| match &key.body {
        Body::Tuple(pair) => match pair.as_slice() {
            [Node { body: Body::Number { value, .. }, .. }, node] => Some((*value, node)),
            _ => None,
        },
        _ => None,
    })
}
