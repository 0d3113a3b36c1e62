//! One document behind another.

mod shift;

use std::collections::BTreeSet;
use std::mem::take;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};

use self::shift::{ROOT_TABLES, Shift};
use crate::document::{Buffer, Gltf, Source};
use crate::edit::whole;
use crate::error::{AssetError, Place, Warning, printable};
use crate::graph::{Graph, Node};
use crate::limits::Budget;
use crate::save::{VIEW_EXTENSIONS, move_view};
use crate::schema::TABLES;

/// Tables whose entries are appended otherwise.
const APART: [&str; 2] = ["buffers", "scenes"];

impl Gltf {
    /// Appends all of another document: the entries of its tables stand behind those of this one and refer to each other as before,
    /// its buffers are in this one's, its images too where they were files. What was there does not move.
    ///
    /// What its scene shows joins the scene of this one, below a node called `name`; a single root of that name is that node.
    /// A skinned mesh, whose own place does not count, stays a root, as the standard recommends. Gives these nodes, that of the
    /// name first. Scenes of it that are not shown are left out with a warning; so is an extension of the document as a whole
    /// that both have, where it is unknown how two become one. An unknown extension with numbers that may be indices is kept as
    /// it is, with a warning.
    ///
    /// # Errors
    ///
    /// Tables or nodes that are malformed; a node of the scene that is another node's child.
    pub fn merge(&mut self, other: Self, name: &str) -> Result<Vec<usize>, AssetError> {
        let file = other.file.clone();
        let graph = other.graph(&mut Budget::new(&other.limits), &mut Vec::new());
        let parts = graph.and_then(|graph| Ok((other.roots(&graph)?, graph)));
        let (roots, graph) = parts.map_err(|error| error.in_file(&file))?;
        let shown = self.own_scene()?;
        self.append_all(other, name, (&roots, &graph), shown).map_err(|error| error.in_file(&file))
    }

    fn append_all(
        &mut self,
        mut other: Self,
        name: &str,
        (roots, graph): (&[usize], &Graph),
        scene: usize,
    ) -> Result<Vec<usize>, AssetError> {
        self.tell_of(&other);
        let images = other.loose_images();
        let strays = other.stray_images(&images);
        let mut shift = self.shift();
        let own = |key: &str| shift.by.get(key).copied().unwrap_or(0);
        let (views, pictures, first) = (own("bufferViews"), own("images"), own("nodes"));
        let starts = self.take_buffers(&mut other)?;
        for view in other.json.get_mut("bufferViews").and_then(Value::as_array_mut).into_iter().flatten() {
            move_view(view, &starts);
            for extension in VIEW_EXTENSIONS {
                if let Some(packed) = view.get_mut("extensions").and_then(|all| all.get_mut(extension)) {
                    move_view(packed, &starts);
                }
            }
        }
        for (view, error) in take(&mut other.undecoded) {
            self.undecoded.insert(views.saturating_add(view), error);
        }
        self.join_extensions(&mut other.json, &mut shift)?;
        for &(key, members) in TABLES.iter().filter(|(key, _)| !APART.contains(key)) {
            let Some(Value::Array(mut entries)) = other.json.get_mut(key).map(Value::take) else { continue };
            for entry in &mut entries {
                shift.entry(key, entry, members);
            }
            self.table_mut(key)?.extend(entries);
        }
        for (index, media, bytes) in images {
            let view = self.append_view(bytes, None)?;
            let image = self.entry_mut("images", pictures.saturating_add(index))?;
            image.shift_remove("uri");
            image.insert("mimeType".to_owned(), json!(media));
            image.insert("bufferView".to_owned(), json!(view));
        }
        for (index, uri) in strays {
            self.entry_mut("images", pictures.saturating_add(index))?.insert("uri".to_owned(), json!(uri));
        }
        self.join_lists(&other.json)?;
        for extension in shift.doubts {
            let message = format!(
                "{}: the extension {extension} may refer to things by number, and these numbers have changed",
                printable(&other.file)
            );
            self.warn("merged-extension", message);
        }
        self.show(name, &other.json, (roots, graph), (first, scene))
    }

    /// By how much what another document refers to moves. Which buffer a view is of is seen to with the buffers.
    fn shift(&self) -> Shift {
        let mut shift = Shift::default();
        for &(key, _) in TABLES {
            let own = if key == "buffers" { 0 } else { self.list(key).len() };
            shift.by.insert(key.to_owned(), own);
        }
        for &(extension, key, _) in ROOT_TABLES {
            let own = self.json.pointer(&format!("/extensions/{extension}/{key}")).and_then(Value::as_array);
            shift.by.insert(format!("{extension}/{key}"), own.map_or(0, Vec::len));
        }
        shift
    }

    /// Puts the roots of a scene, moved by `first`, into our `scene`.
    fn show(
        &mut self,
        name: &str,
        other: &Value,
        (roots, graph): (&[usize], &Graph),
        (first, scene): (usize, usize),
    ) -> Result<Vec<usize>, AssetError> {
        // Nothing places it, and nobody but itself is to be found by the name.
        let is_apart = |node: &Node| {
            let below: Vec<usize> = node.children.iter().map(|child| child.saturating_add(first)).collect();
            node.skin.is_some() && node.mesh.is_some() && self.mesh_nodes(&below).is_empty()
        };
        let (apart, below): (Vec<usize>, Vec<usize>) =
            roots.iter().partition(|&&root| graph.nodes.get(root).is_some_and(is_apart));
        let moved = |nodes: Vec<usize>| nodes.into_iter().map(|node| node.saturating_add(first));
        let (apart, below): (Vec<usize>, Vec<usize>) = (moved(apart).collect(), moved(below).collect());
        let mut out = match below.as_slice() {
            [one] if self.node_name(*one) == Some(name) => vec![*one],
            below => {
                let mut node = json!({ "name": name });
                if !below.is_empty() {
                    node["children"] = json!(below);
                }
                if let Some(extras) = other.get("extras") {
                    node["extras"] = extras.clone();
                }
                vec![self.append("nodes", node)?]
            }
        };
        out.extend(apart);
        let shown = self.entry_mut("scenes", scene)?.entry("nodes").or_insert_with(|| json!([]));
        let pointer = Place::Pointer(format!("/scenes/{scene}/nodes"));
        let list = shown.as_array_mut();
        list.ok_or_else(|| AssetError::new(pointer, "a value of another kind", "an array"))?
            .extend(out.iter().map(|&node| json!(node)));
        Ok(out)
    }

    /// The scene that is shown; made of all roots where there is none.
    fn own_scene(&mut self) -> Result<usize, AssetError> {
        if let Some(reference) = self.root().get("scene")? {
            return Ok(self.follow("scenes", reference)?.0);
        }
        if self.count("scenes")? > 0 {
            return Ok(0);
        }
        let roots = self.graph(&mut Budget::new(&self.limits), &mut Vec::new())?.roots();
        let index = self.append("scenes", json!({ "nodes": roots }))?;
        if let Some(root) = self.json.as_object_mut() {
            root.insert("scene".to_owned(), json!(index));
        }
        Ok(index)
    }

    /// Takes the bytes of the buffers of another document: for each the buffer and the byte in it where it is now.
    fn take_buffers(&mut self, other: &mut Self) -> Result<Vec<(usize, usize)>, AssetError> {
        let mut starts = Vec::with_capacity(other.buffers.len());
        let entries = other.list("buffers").to_vec();
        for (mut buffer, entry) in take(&mut other.buffers).into_iter().zip(entries) {
            if buffer.source == Source::Fallback {
                starts.push((self.append("buffers", entry)?, 0));
                self.buffers.push(buffer);
                continue;
            }
            let index = self.growing()?;
            let misshapen = || AssetError::new(Place::Pointer("/buffers".into()), "none", "a buffer");
            let Buffer { bytes, length, .. } = self.buffers.get_mut(index).ok_or_else(misshapen)?;
            starts.push((index, bytes.align()));
            buffer.bytes.truncate(buffer.length);
            bytes.append(buffer.bytes);
            *length = bytes.len();
            let end = *length;
            self.entry_mut("buffers", index)?.insert("byteLength".to_owned(), json!(end));
        }
        Ok(starts)
    }

    /// Images in files of a kind that no view can have, as URIs with the data in them.
    fn stray_images(&self, known: &[(usize, String, Vec<u8>)]) -> Vec<(usize, String)> {
        let mut budget = Budget::new(&self.limits);
        let known: BTreeSet<usize> = known.iter().map(|image| image.0).collect();
        let is_file = |image: &Value| {
            let uri = image.get("uri").and_then(Value::as_str);
            uri.is_some_and(|uri| matches!(crate::uri::parse(uri), Ok(crate::uri::Target::File(_))))
        };
        let files = self.list("images").iter().enumerate().filter(|(_, image)| is_file(image));
        let mut data = |index| {
            // One that is missing was missing before.
            let image = self.read_image(index, &mut budget).ok()?;
            Some((index, format!("data:application/octet-stream;base64,{}", STANDARD.encode(&image.bytes))))
        };
        files.filter(|(index, _)| !known.contains(index)).filter_map(|(index, _)| data(index)).collect()
    }

    /// What extensions say of the document as a whole.
    fn join_extensions(&mut self, other: &mut Value, shift: &mut Shift) -> Result<(), AssetError> {
        let Some(Value::Object(theirs)) = other.get_mut("extensions").map(Value::take) else { return Ok(()) };
        let misshapen = |expected| AssetError::new(Place::Pointer("/extensions".into()), "none", expected);
        let root = self.json.as_object_mut().ok_or_else(|| misshapen("an object"))?;
        let all = root.entry("extensions").or_insert_with(|| json!({}));
        let all = all.as_object_mut().ok_or_else(|| misshapen("an object"))?;
        let mut left = Vec::new();
        for (name, mut value) in theirs {
            shift.whole_document(&name, &mut value);
            match (all.get_mut(&name), value) {
                (None, value) => drop(all.insert(name, value)),
                (Some(Value::Object(own)), Value::Object(value)) if Shift::has_tables(&name) => {
                    join_tables(own, value);
                }
                (Some(own), value) if *own == value => {}
                _ => left.push(name),
            }
        }
        for name in left {
            let message = format!(
                "what the extension {name} says of the document as a whole is left out: the other has it"
            );
            self.warn("merged-extension", message);
        }
        Ok(())
    }

    /// The names of extensions, and who holds rights.
    fn join_lists(&mut self, other: &Value) -> Result<(), AssetError> {
        for key in ["extensionsUsed", "extensionsRequired"] {
            let names = other.get(key).and_then(Value::as_array).into_iter().flatten();
            let new: Vec<Value> = names.filter(|name| !self.list(key).contains(name)).cloned().collect();
            if !new.is_empty() {
                self.table_mut(key)?.extend(new);
            }
        }
        let holder = |json: &Value| json.pointer("/asset/copyright")?.as_str().map(str::to_owned);
        let both = match (holder(&self.json), holder(other)) {
            (Some(own), Some(theirs)) if own != theirs => Some(format!("{own}; {theirs}")),
            (None, theirs) => theirs,
            _ => None,
        };
        if let (Some(both), Some(asset)) = (both, self.json.get_mut("asset").and_then(Value::as_object_mut)) {
            asset.insert("copyright".to_owned(), json!(both));
        }
        Ok(())
    }

    /// Takes over what is told of a document, and tells what of it does not come along.
    fn tell_of(&mut self, other: &Self) {
        let file = printable(&other.file);
        for Warning { code, place, message } in &other.warnings {
            let place = place.to_string();
            let place = place.trim_start_matches([':', ' ']);
            let space = if place.is_empty() { "" } else { ": " };
            self.warn(code, format!("{file}: {place}{space}{message}"));
        }
        let left = other.list("scenes").len().saturating_sub(1);
        if left > 0 {
            self.warn("merged-scenes", format!("{file}: scenes that are not shown are left out: {left}"));
        }
        if !other.chunks.is_empty() {
            self.warn("merged-chunks", format!("{file}: the chunks behind BIN are left out"));
        }
    }
}

/// Appends the lists of an object to those of another, and takes over what that has not.
fn join_tables(own: &mut Map<String, Value>, theirs: Map<String, Value>) {
    for (key, value) in theirs {
        match (own.get_mut(&key), value) {
            (Some(Value::Array(own)), Value::Array(mut more)) => own.append(&mut more),
            (None, value) => drop(own.insert(key, value)),
            _ => {}
        }
    }
}

/// A whole number moved up.
fn moved(value: &Value, by: usize) -> Option<Value> {
    Some(json!(whole(value)?.checked_add(by)?))
}
