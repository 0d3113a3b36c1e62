//! What the standard says of each object of a document: the types of its members, what they refer to, which of them must be
//! there.
//!
//! [glTF 2.0] §5, *Properties Reference*. Left out is what harms no reader, and real files have: empty lists, factors beyond their
//! range. Members that are not listed are nobody's business, extensions least of all.
//!
//! [glTF 2.0]: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html#properties-reference

use Kind::{Code, Flag, Index, List, Map, Number, Numbers, Object, Sampler, Text, Whole, Word};

/// What a value may be.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    Flag,
    Number,
    /// A whole number from 0.
    Whole,
    Text,
    /// So many numbers.
    Numbers(usize),
    /// One of these strings, but what an extension of its object allows.
    Word(&'static [&'static str]),
    /// One of these numbers, but what an extension of its object allows.
    Code(&'static [u64]),
    /// An index into this table of the document.
    Index(&'static str),
    /// An index into the samplers of the same animation.
    Sampler,
    List(&'static Kind),
    /// An object of any keys and of values of one kind.
    Map(&'static Kind),
    Object(&'static [Member]),
}

/// A member of an object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Member {
    pub(crate) key: &'static str,
    pub(crate) kind: Kind,
    pub(crate) required: bool,
}

pub(crate) const fn may(key: &'static str, kind: Kind) -> Member {
    Member { key, kind, required: false }
}

const fn must(key: &'static str, kind: Kind) -> Member {
    Member { key, kind, required: true }
}

const NAME: Member = may("name", Text);
const INDEX_TYPES: &[u64] = &[5121, 5123, 5125];
const WRAPS: &[u64] = &[10497, 33071, 33648];
const TEXTS: Kind = List(&Text);

/// The members of a document that are no tables.
pub(crate) const DOCUMENT: &[Member] = &[
    must("asset", Object(ASSET)),
    may("scene", Index("scenes")),
    may("extensionsUsed", TEXTS),
    may("extensionsRequired", TEXTS),
];

/// The tables of a document, and what an entry of each has.
pub(crate) const TABLES: &[(&str, &[Member])] = &[
    ("buffers", BUFFER),
    // Before what refers to their bytes.
    ("bufferViews", BUFFER_VIEW),
    ("accessors", ACCESSOR),
    ("animations", ANIMATION),
    ("cameras", CAMERA),
    ("images", IMAGE),
    ("materials", MATERIAL),
    ("meshes", MESH),
    ("nodes", NODE),
    ("samplers", SAMPLER),
    ("scenes", SCENE),
    ("skins", SKIN),
    ("textures", TEXTURE),
];

const ASSET: &[Member] =
    &[must("version", Text), may("minVersion", Text), may("generator", Text), may("copyright", Text)];

const BUFFER: &[Member] = &[must("byteLength", Whole), may("uri", Text), NAME];

const BUFFER_VIEW: &[Member] = &[
    must("buffer", Index("buffers")),
    must("byteLength", Whole),
    may("byteOffset", Whole),
    may("byteStride", Whole),
    may("target", Code(&[34962, 34963])),
    NAME,
];

const ACCESSOR: &[Member] = &[
    must("componentType", Code(&[5120, 5121, 5122, 5123, 5125, 5126])),
    must("count", Whole),
    must("type", Word(&["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"])),
    may("bufferView", Index("bufferViews")),
    may("byteOffset", Whole),
    may("normalized", Flag),
    may("min", List(&Number)),
    may("max", List(&Number)),
    may("sparse", Object(SPARSE)),
    NAME,
];

const SPARSE: &[Member] =
    &[must("count", Whole), must("indices", Object(SPARSE_INDICES)), must("values", Object(SPARSE_VALUES))];

const SPARSE_INDICES: &[Member] = &[
    must("bufferView", Index("bufferViews")),
    must("componentType", Code(INDEX_TYPES)),
    may("byteOffset", Whole),
];

const SPARSE_VALUES: &[Member] = &[must("bufferView", Index("bufferViews")), may("byteOffset", Whole)];

const ANIMATION: &[Member] =
    &[must("channels", List(&Object(CHANNEL))), must("samplers", List(&Object(ANIMATION_SAMPLER))), NAME];

const CHANNEL: &[Member] = &[must("sampler", Sampler), must("target", Object(TARGET))];

const TARGET: &[Member] =
    &[must("path", Word(&["translation", "rotation", "scale", "weights"])), may("node", Index("nodes"))];

const ANIMATION_SAMPLER: &[Member] = &[
    must("input", Index("accessors")),
    must("output", Index("accessors")),
    may("interpolation", Word(&["LINEAR", "STEP", "CUBICSPLINE"])),
];

const CAMERA: &[Member] = &[
    must("type", Word(&["perspective", "orthographic"])),
    may("perspective", Object(PERSPECTIVE)),
    may("orthographic", Object(ORTHOGRAPHIC)),
    NAME,
];

const PERSPECTIVE: &[Member] =
    &[must("yfov", Number), must("znear", Number), may("zfar", Number), may("aspectRatio", Number)];

const ORTHOGRAPHIC: &[Member] =
    &[must("xmag", Number), must("ymag", Number), must("zfar", Number), must("znear", Number)];

const IMAGE: &[Member] =
    &[may("uri", Text), may("bufferView", Index("bufferViews")), may("mimeType", Text), NAME];

const MATERIAL: &[Member] = &[
    may("pbrMetallicRoughness", Object(METALLIC_ROUGHNESS)),
    may("normalTexture", Object(NORMAL_TEXTURE)),
    may("occlusionTexture", Object(OCCLUSION_TEXTURE)),
    may("emissiveTexture", Object(TEXTURE_INFO)),
    may("emissiveFactor", Numbers(3)),
    may("alphaMode", Word(&["OPAQUE", "MASK", "BLEND"])),
    may("alphaCutoff", Number),
    may("doubleSided", Flag),
    NAME,
];

const METALLIC_ROUGHNESS: &[Member] = &[
    may("baseColorFactor", Numbers(4)),
    may("baseColorTexture", Object(TEXTURE_INFO)),
    may("metallicFactor", Number),
    may("roughnessFactor", Number),
    may("metallicRoughnessTexture", Object(TEXTURE_INFO)),
];

const TEXTURE_INFO: &[Member] = &[must("index", Index("textures")), may("texCoord", Whole)];

const NORMAL_TEXTURE: &[Member] =
    &[must("index", Index("textures")), may("texCoord", Whole), may("scale", Number)];

const OCCLUSION_TEXTURE: &[Member] =
    &[must("index", Index("textures")), may("texCoord", Whole), may("strength", Number)];

const MESH: &[Member] = &[must("primitives", List(&Object(PRIMITIVE))), may("weights", List(&Number)), NAME];

const ATTRIBUTES: Kind = Map(&Index("accessors"));

const PRIMITIVE: &[Member] = &[
    must("attributes", ATTRIBUTES),
    may("indices", Index("accessors")),
    may("material", Index("materials")),
    may("mode", Code(&[0, 1, 2, 3, 4, 5, 6])),
    may("targets", List(&ATTRIBUTES)),
];

const NODE: &[Member] = &[
    NAME,
    may("children", List(&Index("nodes"))),
    may("mesh", Index("meshes")),
    may("skin", Index("skins")),
    may("camera", Index("cameras")),
    may("translation", Numbers(3)),
    may("rotation", Numbers(4)),
    may("scale", Numbers(3)),
    may("matrix", Numbers(16)),
    may("weights", List(&Number)),
];

const SAMPLER: &[Member] = &[
    may("magFilter", Code(&[9728, 9729])),
    may("minFilter", Code(&[9728, 9729, 9984, 9985, 9986, 9987])),
    may("wrapS", Code(WRAPS)),
    may("wrapT", Code(WRAPS)),
    NAME,
];

const SCENE: &[Member] = &[may("nodes", List(&Index("nodes"))), NAME];

const SKIN: &[Member] = &[
    must("joints", List(&Index("nodes"))),
    may("inverseBindMatrices", Index("accessors")),
    may("skeleton", Index("nodes")),
    NAME,
];

const TEXTURE: &[Member] = &[may("source", Index("images")), may("sampler", Index("samplers")), NAME];
