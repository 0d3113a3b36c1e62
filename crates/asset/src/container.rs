//! The GLB container: a header of 12 bytes, a JSON chunk, perhaps a BIN chunk, and chunks nobody knows yet.

use std::ops::Range;

use crate::content::{Content, Contents};
use crate::error::{AssetError, Place};

/// `glTF`, little endian.
pub(crate) const MAGIC: [u8; 4] = *b"glTF";
const VERSION: u32 = 2;
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// A GLB file cut into its chunks.
#[derive(Debug)]
pub(crate) struct Chunks<'a> {
    pub(crate) json: &'a [u8],
    /// Which bytes of the file are those of the BIN chunk.
    pub(crate) bin: Option<Range<usize>>,
    /// Everything behind the chunks above, headers included; kept as it is.
    pub(crate) rest: &'a [u8],
    /// How many bytes follow the length that the header declares; they are not part of the file.
    pub(crate) beyond: usize,
}

/// Cuts a GLB file into its chunks.
pub(crate) fn parse(bytes: &[u8]) -> Result<Chunks<'_>, AssetError> {
    let at = |byte: usize, found: String, expected: &str| {
        AssetError::new(Place::Byte(byte as u64), found, expected)
    };
    if bytes.len() < HEADER || bytes[..4] != MAGIC {
        return Err(at(0, format!("{} bytes that are no GLB header", bytes.len()), "a glTF binary file"));
    }
    let version = word(bytes, 4).unwrap_or(0);
    if version != VERSION {
        return Err(at(4, format!("container version {version}"), "version 2"));
    }
    let length = word(bytes, 8).unwrap_or(0) as usize;
    let Some(body) = bytes.get(..length) else {
        return Err(at(8, format!("{} bytes of a file of {length}", bytes.len()), "the whole file"));
    };
    let (kind, json, mut next) =
        chunk(body, HEADER)?.ok_or_else(|| at(HEADER, "no chunk".to_owned(), "a JSON chunk"))?;
    if kind != JSON {
        return Err(at(HEADER + 4, format!("a chunk of type {kind:#010x}"), "a JSON chunk first"));
    }
    let mut bin = None;
    if let Some((BIN, data, end)) = chunk(body, next)? {
        bin = Some(end - data.len()..end);
        next = end;
    }
    let rest = body.get(next..).unwrap_or(&[]);
    while let Some((_, _, end)) = chunk(body, next)? {
        next = end;
    }
    Ok(Chunks { json, bin, rest, beyond: bytes.len() - length })
}

/// The chunk at byte `at`: its type, its data and where the next one starts; none at the end of the file.
#[expect(clippy::type_complexity, reason = "three values that are taken apart at once")]
fn chunk(body: &[u8], at: usize) -> Result<Option<(u32, &[u8], usize)>, AssetError> {
    if at >= body.len() {
        return Ok(None);
    }
    let place = Place::Byte(at as u64);
    let (Some(length), Some(kind)) = (word(body, at), word(body, at + 4)) else {
        return Err(AssetError::new(
            place,
            format!("{} bytes", body.len() - at),
            "a chunk header of 8 bytes",
        ));
    };
    let start = at + CHUNK_HEADER;
    let end = (start as u64).saturating_add(length as u64);
    match body.get(start..usize::try_from(end).unwrap_or(usize::MAX)) {
        Some(data) => Ok(Some((kind, data, start + data.len()))),
        None => Err(AssetError::new(
            place,
            format!("a chunk of {length} bytes"),
            format!("at most the {} bytes that follow", body.len() - start),
        )),
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at.checked_add(4)?)?.try_into().ok().map(u32::from_le_bytes)
}

/// A GLB file in parts: JSON padded with spaces, BIN with zeros, `rest` as it is.
pub(crate) fn assemble(json: &[u8], bin: Option<Contents>, rest: &[u8]) -> Result<Vec<Content>, AssetError> {
    let (before, after) = around(json, bin.as_ref().map(Contents::len), rest)?;
    let mut out = Contents::from(Content::from(before));
    out.append(bin.unwrap_or_default());
    out.push(after.into());
    Ok(out.into_parts())
}

/// What stands in a GLB file before the bytes of a BIN chunk of `bin` bytes, and what behind them.
fn around(json: &[u8], bin: Option<usize>, rest: &[u8]) -> Result<(Vec<u8>, Vec<u8>), AssetError> {
    let padded = |length: usize| length.div_ceil(4) * 4;
    let mut total = HEADER + CHUNK_HEADER + padded(json.len()) + rest.len();
    total += bin.map_or(0, |bin| CHUNK_HEADER + padded(bin));
    let Ok(length) = u32::try_from(total) else {
        return Err(AssetError::file(format!("a GLB of {total} bytes"), "less than 4 GiB: write a .gltf")
            .of_class(crate::ErrorClass::Limit));
    };
    let mut before = crate::limits::reserve(HEADER + 2 * CHUNK_HEADER + padded(json.len()))?;
    before.extend_from_slice(&MAGIC);
    before.extend_from_slice(&VERSION.to_le_bytes());
    before.extend_from_slice(&length.to_le_bytes());
    let chunk = |out: &mut Vec<u8>, length: usize, kind: u32| {
        out.extend_from_slice(&(padded(length) as u32).to_le_bytes());
        out.extend_from_slice(&kind.to_le_bytes());
    };
    chunk(&mut before, json.len(), JSON);
    before.extend_from_slice(json);
    before.resize(padded(before.len()), b' ');
    let mut after = Vec::new();
    if let Some(bin) = bin {
        chunk(&mut before, bin, BIN);
        after.resize(padded(bin) - bin, 0);
    }
    after.extend_from_slice(rest);
    Ok((before, after))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(json: &[u8], bin: Option<&[u8]>, rest: &[u8]) -> Vec<u8> {
        let bin = bin.map(|bin| Content::from(bin.to_vec()).into());
        assemble(json, bin, rest).unwrap().iter().flat_map(|part| part.bytes().unwrap().to_vec()).collect()
    }

    #[test]
    fn chunks_survive_and_unknown_ones_stay_byte_for_byte() {
        let rest = [4, 0, 0, 0, b'X', b'Y', b'Z', b'W', 1, 2, 3, 4];
        let bytes = glb(b"{}", Some(&[1, 2, 3]), &rest);
        let chunks = parse(&bytes).unwrap();
        let bin = chunks.bin.map(|bin| &bytes[bin]);
        assert_eq!((chunks.json, bin), (&b"{}  "[..], Some(&[1, 2, 3, 0][..])));
        assert_eq!((chunks.rest, chunks.beyond), (&rest[..], 0));
        assert_eq!(parse(&glb(b"{} ", None, &rest)).unwrap().rest, rest);
    }

    #[test]
    fn every_cut_of_a_file_is_refused() {
        let bytes = glb(b"{\"asset\":{}}", Some(&[0; 20]), &[]);
        for length in 0..bytes.len() {
            assert!(parse(&bytes[..length]).is_err(), "cut at {length}");
        }
    }
}
