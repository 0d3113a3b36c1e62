//! Images as they are encoded in a document or in files beside it. Decoding them is the caller's job.

use std::borrow::Cow;

use crate::document::Gltf;
use crate::error::AssetError;
use crate::limits::Budget;
use crate::uri;

/// An image as it is stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncodedImage<'a> {
    /// The bytes of a PNG, a JPEG or another format.
    pub bytes: Cow<'a, [u8]>,
    /// Its media type: what the first bytes say, else the document.
    pub media_type: Option<String>,
}

impl Gltf {
    /// The image of that index, from a buffer view, a data URI or a file below the document's folder.
    ///
    /// # Errors
    ///
    /// An image that is not there, cannot be read or is malformed; the limits.
    pub fn image(&self, index: usize) -> Result<EncodedImage<'_>, AssetError> {
        let mut budget = Budget::new(&self.limits);
        self.read_image(index, &mut budget).map_err(|error| error.in_file(&self.file))
    }

    pub(crate) fn read_image(
        &self,
        index: usize,
        budget: &mut Budget,
    ) -> Result<EncodedImage<'_>, AssetError> {
        let image = self.root().need("images")?.item(index)?;
        let mut stated = image.get("mimeType")?.and_then(|kind| kind.value().as_str()).map(str::to_owned);
        let bytes = match image.get("uri")? {
            None => Cow::Borrowed(self.view(image.need("bufferView")?)?.0),
            Some(uri) => match uri::parse(uri.string()?).map_err(|expected| uri.fault(expected))? {
                uri::Target::Data(media, bytes) => {
                    stated = stated.or(media);
                    Cow::Owned(bytes)
                }
                uri::Target::File(path) => Cow::Owned(self.read_beside(uri, &path, budget)?),
            },
        };
        if bytes.is_empty() {
            return Err(image.found("no bytes", "an image"));
        }
        let media_type = media_type(&bytes).map(str::to_owned).or(stated);
        Ok(EncodedImage { bytes, media_type })
    }
}

/// The media type that the first bytes of an image say.
pub(crate) fn media_type(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, 0xff, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => Some("image/ktx2"),
        _ => None,
    }
}
