//! Attributes of refined primitives: those of the old vertices, then what lies between those of the parents.

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::Added;
use super::skin::Influences;
use crate::accessor::{Accessor, Component};
use crate::attributes::bounds;
use crate::document::Gltf;
use crate::edit::{FLOAT, VERTICES, set_bounds};
use crate::error::{AssetError, Warning};
use crate::json::Json;
use crate::limits::{Budget, Of};

/// An attribute of all vertices, ready to be written.
struct Column {
    name: String,
    /// `"VEC3"` and so on.
    kind: String,
    lanes: usize,
    numbers: Numbers,
}

enum Numbers {
    Floats(Vec<f32>),
    Integers { component: Component, normalized: bool, values: Vec<i64> },
}

/// Attributes of a primitive and its targets, by name.
type Appended = (Map<String, Value>, Option<Value>);

impl Gltf {
    /// Appends the attributes and targets of a primitive with vertices added.
    pub(super) fn append_grown(
        &mut self,
        mesh: usize,
        primitive: usize,
        added: &Added,
        budget: &mut Budget,
    ) -> Result<Appended, AssetError> {
        let json = self.root().need("meshes")?.item(mesh)?.need("primitives")?.item(primitive)?;
        let mut warnings = Vec::new();
        let reader = Grower { gltf: self, added };
        let own = reader.columns(json.need("attributes")?, false, budget, &mut warnings)?;
        let mut of_targets = Vec::new();
        if let Some(targets) = json.get("targets")? {
            for target in targets.items()? {
                of_targets.push(reader.columns(target, true, budget, &mut warnings)?);
            }
        }
        self.warnings.append(&mut warnings);
        let attributes = self.append_columns(own, false)?;
        let mut targets = Vec::new();
        for columns in of_targets {
            targets.push(Value::Object(self.append_columns(columns, true)?));
        }
        Ok((attributes, (!targets.is_empty()).then_some(Value::Array(targets))))
    }

    fn append_columns(
        &mut self,
        columns: Vec<Column>,
        displaces: bool,
    ) -> Result<Map<String, Value>, AssetError> {
        let mut out = Map::new();
        for column in columns {
            let with_bounds = column.name == "POSITION";
            let accessor = match &column.numbers {
                Numbers::Floats(values) if displaces && column.kind == "VEC3" => {
                    self.append_deltas(values.as_chunks::<3>().0.to_vec(), with_bounds)?
                }
                Numbers::Floats(values) => self.append_numbers(values, &column, with_bounds)?,
                Numbers::Integers { component, normalized, values } => {
                    self.append_integers(values, *component, *normalized, &column)?
                }
            };
            out.insert(column.name, json!(accessor));
        }
        Ok(out)
    }

    fn append_numbers(
        &mut self,
        values: &[f32],
        column: &Column,
        with_bounds: bool,
    ) -> Result<usize, AssetError> {
        let mut bytes = crate::limits::reserve(values.len() * 4)?;
        for value in values {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        let view = self.append_view(bytes, Some(VERTICES))?;
        let count = values.len() / column.lanes;
        let mut accessor =
            json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": column.kind });
        if with_bounds {
            set_bounds(&mut accessor, Some(bounds(values.as_chunks::<3>().0)));
        }
        self.append("accessors", accessor)
    }

    /// Vertices of integers start at multiples of four bytes, as the standard asks.
    fn append_integers(
        &mut self,
        values: &[i64],
        component: Component,
        normalized: bool,
        column: &Column,
    ) -> Result<usize, AssetError> {
        let packed = component.size() * column.lanes;
        let stride = packed.next_multiple_of(4);
        let count = values.len() / column.lanes;
        let mut bytes = crate::limits::reserve(count * stride)?;
        for vertex in values.chunks_exact(column.lanes) {
            for value in vertex {
                bytes.extend_from_slice(&value.to_le_bytes()[..component.size()]);
            }
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        let view = self.append_view(bytes, Some(VERTICES))?;
        if stride != packed {
            self.entry_mut("bufferViews", view)?.insert("byteStride".to_owned(), json!(stride));
        }
        let mut accessor = json!({
            "bufferView": view, "componentType": component.code(), "count": count, "type": column.kind,
        });
        if normalized {
            accessor["normalized"] = json!(true);
        }
        self.append("accessors", accessor)
    }
}

/// Reads attributes and adds those of new vertices.
struct Grower<'a> {
    gltf: &'a Gltf,
    added: &'a Added,
}

impl Grower<'_> {
    /// The attributes of a primitive, or of a target that `displaces` them.
    fn columns(
        &self,
        attributes: Json<'_>,
        displaces: bool,
        budget: &mut Budget,
        warnings: &mut Vec<Warning>,
    ) -> Result<Vec<Column>, AssetError> {
        let mut influences = if displaces { None } else { Influences::read(self.gltf, attributes, budget)? };
        for (&parents, &share) in self.added.parents.iter().zip(&self.added.shares) {
            influences.as_mut().map(|influences| influences.push_between(parents, share));
        }
        let mut out = Vec::new();
        for (name, reference) in attributes.members()? {
            let accessor = self.gltf.accessor(reference)?;
            let count = (accessor.count + self.added.parents.len()) as u64;
            budget.charge(Of::ExpandedBytes, count * 4 * accessor.lanes as u64, || accessor.json.place())?;
            let numbers = match influences.as_ref().and_then(|found| of_skin(found, name, &accessor)) {
                Some(numbers) => Some(numbers),
                None => self.numbers(name, &accessor, displaces, budget)?,
            };
            let Some(numbers) = numbers else {
                let message = format!("matrices of integers: the finer mesh is without {name}");
                warnings.push(Warning::new("attribute", accessor.json.place(), message));
                continue;
            };
            let kind = accessor.json.need("type")?.string()?.to_owned();
            out.push(Column { name: name.to_owned(), kind, lanes: accessor.lanes, numbers });
        }
        Ok(out)
    }

    /// One attribute; nothing where it is a matrix of integers, whose columns have gaps.
    fn numbers(
        &self,
        name: &str,
        accessor: &Accessor<'_>,
        displaces: bool,
        budget: &mut Budget,
    ) -> Result<Option<Numbers>, AssetError> {
        let added = self.added;
        let floats = |list: Vec<f32>| Ok(Some(Numbers::Floats(list)));
        match (name, accessor.lanes) {
            ("POSITION", 3) if !displaces => {
                let shift = |k: usize| added.shifts.get(k).copied().unwrap_or_default();
                let between = |k, a, b, share| {
                    let (shift, p) = (shift(k), mix(a, b, share));
                    std::array::from_fn(|i| (p[i] + f64::from(shift[i])) as f32)
                };
                floats(grown(accessor.floats::<3>(budget)?, added, between).into_flattened())
            }
            ("NORMAL", 3) if !displaces => {
                let mut old = accessor.floats::<3>(budget)?;
                old.iter_mut().for_each(make_unit);
                floats(grown(old, added, |_, a, b, share| unit(a, b, share)).into_flattened())
            }
            ("TANGENT", 4) if !displaces => {
                let between = |_, [x, y, z, w]: [f32; 4], [p, q, r, _]: [f32; 4], share| {
                    let [x, y, z] = unit([x, y, z], [p, q, r], share);
                    [x, y, z, w]
                };
                let mut old = accessor.floats::<4>(budget)?;
                old.iter_mut().filter_map(|t| t.first_chunk_mut()).for_each(make_unit);
                floats(grown(old, added, between).into_flattened())
            }
            _ if is_kept(name) && accessor.component != Component::F32 => {
                let matrix = accessor.json.need("type")?.string()?.starts_with("MAT");
                if matrix { Ok(None) } else { self.integers(accessor, budget).map(Some) }
            }
            (_, 1) => floats(mixed::<1>(accessor, added, budget)?),
            (_, 2) => floats(mixed::<2>(accessor, added, budget)?),
            (_, 3) => floats(mixed::<3>(accessor, added, budget)?),
            (_, 4) => floats(mixed::<4>(accessor, added, budget)?),
            (_, 9) => floats(mixed::<9>(accessor, added, budget)?),
            _ => floats(mixed::<16>(accessor, added, budget)?),
        }
    }

    /// Integers as they are, what lies between them rounded.
    fn integers(&self, accessor: &Accessor<'_>, budget: &mut Budget) -> Result<Numbers, AssetError> {
        let mut values = match accessor.lanes {
            1 => whole::<1>(accessor, budget)?,
            2 => whole::<2>(accessor, budget)?,
            3 => whole::<3>(accessor, budget)?,
            _ => whole::<4>(accessor, budget)?,
        };
        for (pair, share) in self.added.parents.iter().zip(&self.added.shares) {
            let [a, b] = pair.map(|v| v as usize * accessor.lanes);
            for lane in 0..accessor.lanes {
                let [a, b] = [values[a + lane], values[b + lane]].map(|value| value as f64);
                // Half goes up.
                values.push((a * (1.0 - share) + b * share + 0.5).floor() as i64);
            }
        }
        Ok(Numbers::Integers { component: accessor.component, normalized: accessor.normalized, values })
    }
}

/// Whether an attribute keeps its component type: an application's own, and joints that go with no weights. The types of all
/// others the standard knows, and floats are among them.
fn is_kept(name: &str) -> bool {
    let known = ["POSITION", "NORMAL", "TANGENT"];
    let numbered = ["TEXCOORD_", "COLOR_", "WEIGHTS_"];
    !known.contains(&name) && !numbered.iter().any(|prefix| name.starts_with(prefix))
}

/// Joints in their type, weights as floats: in 8 or 16 bits they would have to be rounded so that they still add up.
fn of_skin(influences: &Influences, name: &str, accessor: &Accessor<'_>) -> Option<Numbers> {
    let set = |prefix: &str| name.strip_prefix(prefix)?.parse::<usize>().ok();
    let joints = set("JOINTS_");
    let set = joints.or_else(|| set("WEIGHTS_")).filter(|&set| set < influences.sets)?;
    let vertices = influences.pairs.chunks_exact(4 * influences.sets);
    let of_set = vertices.flat_map(|vertex| &vertex[4 * set..4 * set + 4]);
    Some(match joints {
        None => Numbers::Floats(of_set.map(|&(_, weight)| weight).collect()),
        Some(_) => Numbers::Integers {
            component: accessor.component,
            normalized: false,
            values: of_set.map(|&(joint, _)| i64::from(joint)).collect(),
        },
    })
}

/// The values of the old vertices, then of each new one what `between` makes of its number, its parents' and its share.
fn grown<const N: usize>(
    mut values: Vec<[f32; N]>,
    added: &Added,
    between: impl Fn(usize, [f32; N], [f32; N], f64) -> [f32; N],
) -> Vec<[f32; N]> {
    values.reserve_exact(added.parents.len());
    for (k, (&[a, b], &share)) in added.parents.iter().zip(&added.shares).enumerate() {
        values.push(between(k, values[a as usize], values[b as usize], share));
    }
    values
}

fn mixed<const N: usize>(
    accessor: &Accessor<'_>,
    added: &Added,
    budget: &mut Budget,
) -> Result<Vec<f32>, AssetError> {
    let between = |_, a: [f32; N], b: [f32; N], share| mix(a, b, share).map(|value| value as f32);
    Ok(grown(accessor.floats::<N>(budget)?, added, between).into_flattened())
}

/// The components as they are stored.
fn whole<const N: usize>(accessor: &Accessor<'_>, budget: &mut Budget) -> Result<Vec<i64>, AssetError> {
    let mut stored = *accessor;
    stored.normalized = false;
    if matches!(stored.component, Component::U8 | Component::U16 | Component::U32) {
        let values = stored.uints::<N>(budget)?.into_flattened();
        return Ok(values.into_iter().map(i64::from).collect());
    }
    Ok(stored.floats::<N>(budget)?.into_flattened().into_iter().map(|value| value as i64).collect())
}

/// Gives a direction the length 1 where it has another, as far as the Khronos validator tells.
fn make_unit(v: &mut [f32; 3]) {
    /// What is left of 8-bit integers: it is no fault.
    const COARSE: f64 = 0.005;
    let wide = crate::way::double(*v);
    if (wide.length() - 1.0).abs() > COARSE {
        *v = wide.try_normalize().map_or(*v, crate::way::single);
    }
}

/// The direction between two; the first where they cancel.
fn unit(a: [f32; 3], b: [f32; 3], share: f64) -> [f32; 3] {
    DVec3::from_array(mix(a, b, share)).try_normalize().map_or(a, crate::way::single)
}

/// What lies between two. At half the products are exact, so that it is the bits of half their sum.
fn mix<const N: usize>(a: [f32; N], b: [f32; N], share: f64) -> [f64; N] {
    std::array::from_fn(|k| f64::from(a[k]) * (1.0 - share) + f64::from(b[k]) * share)
}
