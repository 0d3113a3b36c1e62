//! A glTF document: its JSON as it was read, and the bytes of its buffers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::container;
use crate::content::{Content, Contents};
use crate::error::{AssetError, Place, Warning};
use crate::json::Json;
use crate::limits::{Budget, Limits, Of, reserve};
use crate::meshopt::is_fallback;
use crate::uri;

/// Required extensions that keep the geometry in a form that is not decoded here.
const COMPRESSED: [&str; 1] = ["KHR_draco_mesh_compression"];

/// Extensions that may be required: none of them changes where vertices are or how they are stored, except
/// `KHR_mesh_quantization`, which the accessor views read, and meshopt's compression, which is decoded under them.
const UNDERSTOOD: [&str; 14] = [
    "EXT_lights_image_based",
    "EXT_meshopt_compression",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_techniques_webgl",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
    "MSFT_texture_dds",
];

/// Every extension of this family is about how surfaces look.
const MATERIALS: &str = "KHR_materials_";

/// Where the bytes of a buffer come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// The BIN chunk.
    Bin,
    /// A data URI.
    Data,
    /// A file beside the document.
    File,
    /// Added here.
    New,
    /// Compressed views: nothing of it is written.
    Fallback,
}

#[derive(Clone, Debug)]
pub(crate) struct Buffer {
    /// For the BIN chunk with its padding, so that what is added leaves the old chunk a prefix of the new one.
    pub(crate) bytes: Contents,
    /// The declared length: so many of `bytes` views may refer to.
    pub(crate) length: usize,
    pub(crate) source: Source,
}

/// A glTF 2.0 document, from a `.glb` or a `.gltf` with its buffers, or made anew from meshes.
///
/// The JSON is kept as it was read and edited in place: nothing is renumbered, reordered or dropped, so that
/// whatever is not understood here comes out as it went in.
#[derive(Clone, Debug)]
pub struct Gltf {
    pub(crate) file: String,
    pub(crate) folder: Option<PathBuf>,
    pub(crate) json: Value,
    /// Whether it came as a GLB.
    pub(crate) binary: bool,
    pub(crate) buffers: Vec<Buffer>,
    /// A BIN chunk that no buffer uses.
    pub(crate) orphan: Option<Contents>,
    /// Chunks behind BIN, headers included.
    pub(crate) chunks: Vec<u8>,
    /// Compressed views that cannot be decoded, and why.
    pub(crate) undecoded: BTreeMap<usize, AssetError>,
    pub(crate) limits: Limits,
    pub(crate) warnings: Vec<Warning>,
    /// The buffer that takes new data, once there is one.
    pub(crate) growing: Option<usize>,
    pub(crate) written: crate::delta::Written,
    pub(crate) spill: crate::store::Spill,
}

/// A document that is not to be worked on, since its buffers may be missing: what is told of one that is refused.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Outline {
    /// Its JSON.
    pub json: Value,
    /// Whether it came as a GLB.
    pub binary: bool,
    /// What is not right, what it is refused for among it.
    pub warnings: Vec<Warning>,
}

impl Outline {
    /// Reads what can be read of a `.glb` or a `.gltf`, whether [`Gltf::read`] refuses it or not.
    ///
    /// # Errors
    ///
    /// The file cannot be read, is too large for `limits`, or holds no JSON.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self, AssetError> {
        let name = path.display().to_string();
        let mut budget = Budget::new(limits);
        let folder = path.parent().map(Path::to_path_buf);
        let open = |bytes, budget: &mut Budget| Gltf::open(bytes, &name, folder.clone(), limits, budget);
        let opened = uri::read_file(path, &mut budget).and_then(|bytes| open(bytes, &mut budget));
        let mut gltf = opened.map_err(|error| error.in_file(&name))?;
        // Why it is refused, if it is, its reader says.
        let _ = gltf.load(&mut budget, false);
        let Gltf { json, binary, warnings, .. } = gltf;
        Ok(Self { json, binary, warnings })
    }
}

impl Gltf {
    /// Reads a `.glb` or a `.gltf` with the buffers it refers to. What the file is, its first bytes say.
    ///
    /// # Errors
    ///
    /// The file or one of its buffers cannot be read, is malformed, is too large for `limits`, or the document
    /// requires an extension that is not supported. Geometry is checked where it is read, in [`Gltf::rest`].
    pub fn read(path: &Path, limits: &Limits) -> Result<Self, AssetError> {
        let name = path.display().to_string();
        let mut budget = Budget::new(limits);
        let folder = path.parent().map(Path::to_path_buf);
        uri::read_file(path, &mut budget)
            .and_then(|bytes| Self::parse(bytes, &name, folder, limits, &mut budget))
            .map_err(|error| error.in_file(&name))
    }

    /// Reads a document from memory. `name` stands for it in messages; external buffers are refused.
    pub fn from_slice(bytes: &[u8], name: &str, limits: &Limits) -> Result<Self, AssetError> {
        let mut budget = Budget::new(limits);
        budget
            .charge(Of::FileBytes, bytes.len() as u64, || Place::File)
            .and_then(|()| Self::parse(bytes.to_vec(), name, None, limits, &mut budget))
            .map_err(|error| error.in_file(name))
    }

    fn parse(
        bytes: Vec<u8>,
        name: &str,
        folder: Option<PathBuf>,
        limits: &Limits,
        budget: &mut Budget,
    ) -> Result<Self, AssetError> {
        let mut gltf = Self::open(bytes, name, folder, limits, budget)?;
        gltf.load(budget, true)?;
        Ok(gltf)
    }

    /// The document as JSON, its buffers not yet read.
    fn open(
        bytes: Vec<u8>,
        name: &str,
        folder: Option<PathBuf>,
        limits: &Limits,
        budget: &mut Budget,
    ) -> Result<Self, AssetError> {
        let mut warnings = Vec::new();
        let binary = bytes.starts_with(&container::MAGIC);
        let mut text_of = |text: &[u8]| {
            budget.charge(Of::JsonBytes, text.len() as u64, || Place::File)?;
            parse_json(text)
        };
        let (json, bin, chunks) = if binary {
            let parts = container::parse(&bytes)?;
            if parts.beyond > 0 {
                let message = format!("{} bytes follow the end of the file; they are dropped", parts.beyond);
                warnings.push(Warning::new("trailing-bytes", Place::File, message));
            }
            let (json, chunks) = (text_of(parts.json)?, parts.rest.to_vec());
            let bin = parts.bin.map(|bin| Content::cut(bytes, bin).into());
            (json, bin, chunks)
        } else {
            (text_of(&bytes)?, None, Vec::new())
        };
        Ok(Self {
            file: name.to_owned(),
            folder,
            json,
            binary,
            buffers: Vec::new(),
            orphan: bin,
            chunks,
            undecoded: BTreeMap::new(),
            limits: *limits,
            warnings,
            growing: None,
            written: crate::delta::Written::default(),
            spill: crate::store::Spill::default(),
        })
    }

    /// Reads the buffers of a document that is one, and tells what is wrong with the rest of it: what is `passed` through, or
    /// would have been.
    fn load(&mut self, budget: &mut Budget, passed: bool) -> Result<(), AssetError> {
        check_version(self.root())?;
        let loaded = check_extensions(self.root()).and_then(|()| self.load_buffers(budget));
        self.survey(passed);
        loaded
    }

    /// The file as it was named when it was read.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Whether it came as a GLB.
    pub fn is_binary(&self) -> bool {
        self.binary
    }

    /// The JSON of the document.
    pub fn json(&self) -> &Value {
        &self.json
    }

    /// What was repaired or dropped when the document was read, or left unrepaired when it was edited; and what the standard
    /// does not allow and no reading has met yet: of what is not read it comes out as it is.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Adds to the warnings of the document.
    pub fn warn(&mut self, code: &'static str, message: impl Into<String>) {
        self.warnings.push(Warning::new(code, Place::File, message));
    }

    pub(crate) fn root(&self) -> Json<'_> {
        Json::root(&self.json)
    }

    /// The table `key` of the document, such as `accessors`.
    pub(crate) fn table<'a>(&'a self, key: &'a str) -> Result<Option<Json<'a>>, AssetError> {
        let table = self.root().get(key)?;
        table.map_or(Ok(None), |table| table.array().map(|_| Some(table)))
    }

    /// How many entries the table `key` has.
    pub(crate) fn count(&self, key: &str) -> Result<usize, AssetError> {
        self.table(key)?.map_or(Ok(0), |table| Ok(table.array()?.len()))
    }

    /// The entry of the table `key` that `reference` names by its index.
    pub(crate) fn follow<'a>(
        &'a self,
        key: &'a str,
        reference: Json<'_>,
    ) -> Result<(usize, Json<'a>), AssetError> {
        let index = reference.index(key.trim_end_matches('s'), self.count(key)?)?;
        Ok((index, self.root().need(key)?.item(index)?))
    }

    /// Whether `extensionsUsed` or `extensionsRequired` names `extension`.
    pub(crate) fn uses(&self, extension: &str) -> bool {
        ["extensionsUsed", "extensionsRequired"]
            .iter()
            .filter_map(|list| self.json.get(list)?.as_array())
            .any(|list| list.iter().any(|name| name.as_str() == Some(extension)))
    }

    fn load_buffers(&mut self, budget: &mut Budget) -> Result<(), AssetError> {
        let mut bin = self.orphan.take();
        let mut buffers = Vec::new();
        if let Some(table) = self.table("buffers")? {
            for (index, buffer) in table.items()?.enumerate() {
                let length = buffer.need("byteLength")?.uint()?;
                let (bytes, source) = match buffer.get("uri")? {
                    Some(uri) => self.load_uri(uri, budget)?,
                    None if is_fallback(buffer) => {
                        budget.charge(Of::ExpandedBytes, length as u64, || buffer.place())?;
                        let mut bytes = reserve(length)?;
                        bytes.resize(length, 0);
                        (Content::from(bytes).into(), Source::Fallback)
                    }
                    None => match bin.take().filter(|_| index == 0) {
                        Some(bytes) => (bytes, Source::Bin),
                        None => {
                            return Err(buffer.found("no \"uri\"", "a \"uri\", or a BIN chunk for buffer 0"));
                        }
                    },
                };
                if length == 0 || length > bytes.len() {
                    let expected = format!("1 to {}, the bytes there are", bytes.len());
                    return Err(buffer.need("byteLength")?.fault(expected));
                }
                buffers.push(Buffer { bytes, length, source });
            }
        }
        self.buffers = buffers;
        self.orphan = bin;
        self.decode_views()
    }

    fn load_uri(&self, uri: Json<'_>, budget: &mut Budget) -> Result<(Contents, Source), AssetError> {
        let (bytes, source) = match uri::parse(uri.string()?).map_err(|expected| uri.fault(expected))? {
            uri::Target::Data(_, bytes) => (bytes, Source::Data),
            uri::Target::File(path) => (self.read_beside(uri, &path, budget)?, Source::File),
        };
        Ok((Content::from(bytes).into(), source))
    }

    /// Reads the file below the folder of the document that `uri` names by `path`.
    pub(crate) fn read_beside(
        &self,
        uri: Json<'_>,
        path: &Path,
        budget: &mut Budget,
    ) -> Result<Vec<u8>, AssetError> {
        let folder = self.folder.as_deref().ok_or_else(|| uri.fault("data in the document itself"))?;
        uri::read_below(folder, path, budget).map_err(|mut error| {
            error.place = uri.place();
            error
        })
    }
}

fn parse_json(text: &[u8]) -> Result<Value, AssetError> {
    // Some writers pad with NUL where the standard asks for spaces.
    let end = text.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1);
    if let Some(at) = reserved_key(&text[..end]) {
        let line = text[..at].split(|&b| b == b'\n').count();
        return Err(AssetError::new(
            Place::Line(line),
            format!("the key {RESERVED:?}"),
            "other keys: this one cannot be kept as it is",
        ));
    }
    serde_json::from_slice(&text[..end]).map_err(|error| {
        let place = if error.line() > 0 { Place::Line(error.line()) } else { Place::File };
        AssetError::new(place, format!("text that is not JSON ({error})"), "a glTF document")
    })
}

/// The key by which the JSON reader hands numbers on as they are written: an object that begins with it would come
/// out as a number.
const RESERVED: &str = "$serde_json::private::Number";

/// Where the text has that key, escapes resolved. Of text that is not JSON anything may be said: it is refused next.
fn reserved_key(text: &[u8]) -> Option<usize> {
    let mut at = 0;
    while let Some(start) = text[at..].iter().position(|&b| b == b'"').map(|quote| at + quote) {
        let mut end = start + 1;
        while let Some(&b) = text.get(end).filter(|&&b| b != b'"') {
            end += if b == b'\\' { 2 } else { 1 };
        }
        let string = text.get(start..=end)?;
        at = end + 1;
        // A character is escaped as six at most.
        let candidate = matches!(string[1], b'$' | b'\\') && string.len() <= 6 * RESERVED.len() + 2;
        if candidate
            && text[at..].iter().find(|b| !b.is_ascii_whitespace()) == Some(&b':')
            && serde_json::from_slice::<String>(string).is_ok_and(|key| key == RESERVED)
        {
            return Some(start);
        }
    }
    None
}

fn check_version(root: Json<'_>) -> Result<(), AssetError> {
    let asset = root.need("asset")?;
    let is_two = |version: &str| version == "2" || version.starts_with("2.");
    let version = asset.need("version")?;
    if !is_two(version.string()?) {
        return Err(version.fault("version 2 of glTF"));
    }
    if let Some(least) = asset.get("minVersion")?
        && !matches!(least.string()?, "2" | "2.0")
    {
        return Err(least.fault("at most version 2.0 of glTF"));
    }
    Ok(())
}

fn check_extensions(root: Json<'_>) -> Result<(), AssetError> {
    let Some(required) = root.get("extensionsRequired")? else { return Ok(()) };
    for name in required.items()? {
        let extension = name.string()?;
        if COMPRESSED.contains(&extension) {
            let found = format!("the required extension {extension}");
            return Err(name.found(
                found,
                "uncompressed geometry: decode the file first, with gltf-transform for instance",
            ));
        }
        if !UNDERSTOOD.contains(&extension) && !extension.starts_with(MATERIALS) {
            return Err(
                name.found(format!("the required extension {extension}"), "extensions that are supported")
            );
        }
    }
    Ok(())
}
