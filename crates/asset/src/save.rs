//! A document as files: one `.glb`, or a `.gltf` with what belongs to it.

use std::mem::take;
use std::path::{Path, PathBuf};

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use serde_json::{Value, json};

use crate::container;
use crate::content::{Content, Contents};
use crate::document::{Gltf, Source};
use crate::edit::whole;
use crate::error::AssetError;
use crate::limits::Budget;
use crate::output::OutputFile;
use crate::uri;

/// What a URI may hold as it is.
const ESCAPED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'_').remove(b'.').remove(b'~');

/// Extensions of buffer views that refer to buffers of their own.
pub(crate) const VIEW_EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The two forms of a glTF document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// One binary file.
    Glb,
    /// JSON with files beside it.
    Gltf,
}

impl Format {
    /// The format that the extension of a path names.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        match () {
            () if extension.eq_ignore_ascii_case("glb") => Some(Self::Glb),
            () if extension.eq_ignore_ascii_case("gltf") => Some(Self::Gltf),
            () => None,
        }
    }
}

impl Gltf {
    /// The files of the document when it is written to `out`, in the order in which to write them.
    ///
    /// What was added is in the BIN chunk of a `.glb`, behind the old data, or in a `.bin` of its own beside a
    /// `.gltf`. A `.gltf` that becomes a `.glb` takes its buffers and images into one chunk; a `.glb` that becomes a
    /// `.gltf` leaves its chunk in a `.bin`. Files that the document refers to are copied where the folder differs.
    pub fn files(&self, out: &Path, format: Format) -> Result<Vec<OutputFile>, AssetError> {
        self.clone().into_files(out, format)
    }

    /// The same of a document that is needed no more: its bytes become those of the files, without a copy.
    pub fn into_files(mut self, out: &Path, format: Format) -> Result<Vec<OutputFile>, AssetError> {
        let files = match format {
            Format::Glb => self.glb_files(out),
            Format::Gltf => self.gltf_files(out),
        };
        files.map_err(|error| error.in_file(&self.file))
    }

    /// The document as one GLB, with all buffers and images in it.
    pub fn to_glb(&self) -> Result<Vec<u8>, AssetError> {
        let (json, bin) = self.clone().embedded();
        let glb = text_of(&json).and_then(|text| container::assemble(&text, bin, &self.chunks));
        let glb = glb.and_then(|parts| OutputFile { parts, ..OutputFile::new("", Vec::new()) }.bytes());
        glb.map_err(|error| error.in_file(&self.file))
    }

    /// The files of a GLB; takes the bytes of the buffers.
    fn glb_files(&mut self, out: &Path) -> Result<Vec<OutputFile>, AssetError> {
        let keeps = self.binary && self.buffers.first().is_none_or(|buffer| buffer.source == Source::Bin);
        let mut files = Vec::new();
        let embedded;
        let (json, bin) = if keeps {
            files = self.copies(out);
            let bin = self.buffers.first_mut().map(|buffer| take(&mut buffer.bytes)).or(self.orphan.take());
            (&self.json, bin)
        } else {
            embedded = self.embedded();
            (&embedded.0, embedded.1)
        };
        let parts = container::assemble(&text_of(json)?, bin, &self.chunks)?;
        files.push(OutputFile { parts, ..OutputFile::new(out, Vec::new()) });
        Ok(files)
    }

    /// The files of a `.gltf`; takes the bytes of the buffers that are written.
    fn gltf_files(&mut self, out: &Path) -> Result<Vec<OutputFile>, AssetError> {
        let mut json = self.json.clone();
        let mut files = self.copies(out);
        let stem =
            out.file_stem().map_or_else(|| "out".to_owned(), |stem| stem.to_string_lossy().into_owned());
        let taken: Vec<PathBuf> = self.references().into_iter().map(|(path, _)| path).collect();
        for (index, buffer) in self.buffers.iter_mut().enumerate() {
            let stem = match buffer.source {
                Source::Bin => stem.clone(),
                Source::New => format!("{stem}_wirework"),
                Source::Data | Source::File | Source::Fallback => continue,
            };
            let numbered = (2_usize..).map(|n| format!("{stem}_{n}.bin"));
            let mut names = std::iter::once(format!("{stem}.bin")).chain(numbered);
            let name = names.find(|name| !taken.contains(&PathBuf::from(name))).unwrap_or_default();
            if let Some(entry) = json.pointer_mut(&format!("/buffers/{index}")).and_then(Value::as_object_mut)
            {
                entry.insert("uri".to_owned(), json!(utf8_percent_encode(&name, ESCAPED).to_string()));
            }
            buffer.bytes.truncate(buffer.length);
            let parts = take(&mut buffer.bytes).into_parts();
            files.push(OutputFile { parts, ..OutputFile::new(out.with_file_name(name), Vec::new()) });
        }
        let mut text =
            serde_json::to_vec_pretty(&json).map_err(|error| AssetError::file(error.to_string(), "JSON"))?;
        text.push(b'\n');
        files.push(OutputFile::new(out, text));
        Ok(files)
    }

    /// The files below the input's folder that the document refers to: their paths and the images among them.
    fn references(&self) -> Vec<(PathBuf, Option<usize>)> {
        let mut out = Vec::new();
        let mut add = |value: &Value, image| {
            if let Some(Ok(uri::Target::File(path))) =
                value.get("uri").and_then(Value::as_str).map(uri::parse)
            {
                out.push((path, image));
            }
        };
        self.list("buffers").iter().for_each(|buffer| add(buffer, None));
        self.list("images").iter().enumerate().for_each(|(index, image)| add(image, Some(index)));
        out
    }

    /// Copies of those files, where `out` is in another folder. One that cannot be read is left out: an image that
    /// is missing was missing before.
    fn copies(&self, out: &Path) -> Vec<OutputFile> {
        let Some(from) = self.folder.as_deref() else { return Vec::new() };
        let to = out.parent().unwrap_or(Path::new(""));
        let canonical = |folder: &Path| {
            if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.canonicalize()
        };
        if let (Ok(from), Ok(to)) = (canonical(from), canonical(to))
            && from == to
        {
            return Vec::new();
        }
        let mut budget = Budget::new(&self.limits);
        let mut files: Vec<OutputFile> = Vec::new();
        for (relative, _) in self.references() {
            let path = to.join(&relative);
            if files.iter().any(|file| file.path == path) {
                continue;
            }
            if let Ok(bytes) = uri::read_below(from, &relative, &mut budget) {
                files.push(OutputFile { replace: false, folders: true, ..OutputFile::new(path, bytes) });
            }
        }
        files
    }

    /// The JSON with all buffers and images in one chunk, and that chunk; takes the bytes of the buffers.
    fn embedded(&mut self) -> (Value, Option<Contents>) {
        let images = self.loose_images();
        let mut json = self.json.clone();
        let mut bin = self.orphan.take().unwrap_or_default();
        // Where each buffer goes: into the chunk, from a byte on; one without data stays a buffer of its own.
        let mut starts = Vec::with_capacity(self.buffers.len());
        let mut apart = Vec::new();
        for (index, buffer) in self.buffers.iter_mut().enumerate() {
            if buffer.source == Source::Fallback {
                apart.extend(json.pointer(&format!("/buffers/{index}")).cloned());
                starts.push((apart.len(), 0));
                continue;
            }
            starts.push((0, bin.align()));
            buffer.bytes.truncate(buffer.length);
            bin.append(take(&mut buffer.bytes));
        }
        if starts.len() > 1 || starts.first().is_some_and(|&(_, start)| start > 0) {
            for view in json.get_mut("bufferViews").and_then(Value::as_array_mut).into_iter().flatten() {
                move_view(view, &starts);
                for extension in VIEW_EXTENSIONS {
                    if let Some(view) =
                        view.get_mut("extensions").and_then(|extensions| extensions.get_mut(extension))
                    {
                        move_view(view, &starts);
                    }
                }
            }
        }
        for (index, media, bytes) in images {
            let (offset, length) = (bin.align(), bytes.len());
            bin.push(Content::from(bytes));
            let view = push(
                &mut json,
                "bufferViews",
                json!({ "buffer": 0, "byteOffset": offset, "byteLength": length }),
            );
            if let Some(image) = json.pointer_mut(&format!("/images/{index}")).and_then(Value::as_object_mut)
            {
                image.shift_remove("uri");
                image.insert("mimeType".to_owned(), json!(media));
                image.insert("bufferView".to_owned(), json!(view));
            }
        }
        if bin.is_empty() {
            return (json, None);
        }
        let first = self.buffers.iter().zip(self.list("buffers")).find(|(b, _)| b.source != Source::Fallback);
        let mut first = first.and_then(|(_, entry)| entry.as_object()).cloned().unwrap_or_default();
        first.shift_remove("uri");
        first.insert("byteLength".to_owned(), json!(bin.len()));
        let all: Vec<Value> = std::iter::once(Value::Object(first)).chain(apart).collect();
        json["buffers"] = Value::Array(all);
        (json, Some(bin))
    }

    /// The images that are not in a buffer view yet, and can be taken in.
    pub(crate) fn loose_images(&self) -> Vec<(usize, String, Vec<u8>)> {
        let mut budget = Budget::new(&self.limits);
        let all = 0..self.list("images").len();
        let loose = all.filter_map(|index| Some((index, self.loose_image(index, &mut budget)?)));
        loose.map(|(index, (media, bytes))| (index, media, bytes)).collect()
    }

    /// An image that is not in a buffer view yet, and its media type. None where it cannot be taken in: it then
    /// stays as it is.
    fn loose_image(&self, index: usize, budget: &mut Budget) -> Option<(String, Vec<u8>)> {
        self.list("images").get(index)?.get("uri")?;
        let image = self.read_image(index, budget).ok()?;
        Some((image.media_type?, image.bytes.into_owned()))
    }
}

/// Lets a view refer to where its buffer has gone. One that no buffer can hold, of which reading warned, stays as it is.
pub(crate) fn move_view(view: &mut Value, starts: &[(usize, usize)]) {
    let Some((place, start)) = view.get("buffer").and_then(whole).and_then(|buffer| starts.get(buffer))
    else {
        return;
    };
    let offset = view.get("byteOffset").and_then(whole).unwrap_or(0);
    let Some(moved) = offset.checked_add(*start) else { return };
    if let Some(view) = view.as_object_mut() {
        view.insert("buffer".to_owned(), json!(place));
        if *start > 0 {
            view.insert("byteOffset".to_owned(), json!(moved));
        }
    }
}

fn push(json: &mut Value, key: &str, value: Value) -> usize {
    let Some(root) = json.as_object_mut() else { return 0 };
    match root.entry(key).or_insert_with(|| json!([])).as_array_mut() {
        Some(table) => {
            table.push(value);
            table.len() - 1
        }
        None => 0,
    }
}

fn text_of(json: &Value) -> Result<Vec<u8>, AssetError> {
    serde_json::to_vec(json).map_err(|error| AssetError::file(error.to_string(), "JSON"))
}
