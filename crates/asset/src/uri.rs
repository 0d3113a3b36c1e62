//! URIs of buffers and images: data in the text itself, or a file below the input's folder. Nothing else is ever
//! opened: no scheme, no absolute path, no way up, no device.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use crate::error::{AssetError, ErrorClass, Place};
use crate::limits::{Budget, Of};

/// Padding may be missing: some exporters leave it out, and nothing is lost by that.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Names that are devices on Windows in every folder and with every extension.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// What a URI stands for.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// The data itself, with its media type if one is given.
    Data(Option<String>, Vec<u8>),
    /// A file, relative to the input's folder.
    File(PathBuf),
}

/// Takes a URI apart. The error says what is wrong with it.
pub(crate) fn parse(uri: &str) -> Result<Target, &'static str> {
    if let Some(data) = uri.get(..5).filter(|head| head.eq_ignore_ascii_case("data:")).and(uri.get(5..)) {
        return data_uri(data);
    }
    let path = percent_decode_str(uri).decode_utf8().map_err(|_| "a URI in UTF-8")?;
    below(&path).map(Target::File)
}

/// The file below a folder that a path of forward slashes names. The error says what is wrong with it.
pub(crate) fn below(path: &str) -> Result<PathBuf, &'static str> {
    if path.is_empty() {
        return Err("the name of a file");
    }
    if path.contains(':') {
        return Err("a relative URI without a scheme or a drive");
    }
    if path.starts_with('/') || path.contains('\\') {
        return Err("a relative URI with forward slashes");
    }
    if path.chars().any(char::is_control) {
        return Err("a URI without control characters");
    }
    let mut out = PathBuf::new();
    for segment in path.split('/') {
        match segment {
            "" | "." => {}
            ".." => return Err("a URI that stays below the folder of the input"),
            name if is_device(name) => return Err("the name of a file, not of a device"),
            name => out.push(name),
        }
    }
    if out.as_os_str().is_empty() { Err("the name of a file") } else { Ok(out) }
}

fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or(name).trim_end().to_ascii_lowercase();
    let numbered = |prefix: &str| {
        stem.strip_prefix(prefix).is_some_and(|n| n.len() == 1 && n.bytes().all(|b| b.is_ascii_digit()))
    };
    DEVICES.contains(&stem.as_str()) || numbered("com") || numbered("lpt")
}

/// The part of a data URI behind `data:`.
fn data_uri(text: &str) -> Result<Target, &'static str> {
    let (head, data) = text.split_once(',').ok_or("a data URI with a comma")?;
    let encoded =
        head.len() >= 7 && head.get(head.len() - 7..).is_some_and(|e| e.eq_ignore_ascii_case(";base64"));
    let media = if encoded { &head[..head.len() - 7] } else { head };
    let bytes = if encoded && data.contains('%') {
        let plain: Vec<u8> = percent_decode_str(data).collect();
        BASE64.decode(plain).map_err(|_| "base64 data")?
    } else if encoded {
        BASE64.decode(data).map_err(|_| "base64 data")?
    } else {
        percent_decode_str(data).collect()
    };
    let media = media.split(';').next().unwrap_or_default();
    Ok(Target::Data((!media.is_empty()).then(|| media.to_owned()), bytes))
}

/// Reads the regular file at `path`, charging its size.
pub(crate) fn read_file(path: &Path, budget: &mut Budget) -> Result<Vec<u8>, AssetError> {
    let unreadable = |error: std::io::Error| AssetError::file(error.to_string(), "a readable file");
    let metadata = path.metadata().map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(AssetError::file("no regular file", "a regular file"));
    }
    budget.charge(Of::FileBytes, metadata.len(), || Place::File)?;
    let mut bytes = crate::limits::reserve(usize::try_from(metadata.len()).unwrap_or(usize::MAX))?;
    let room = budget.file_bytes_left();
    let mut file =
        File::open(path).map_err(unreadable)?.take(metadata.len().saturating_add(room).saturating_add(1));
    file.read_to_end(&mut bytes).map_err(unreadable)?;
    let grown = (bytes.len() as u64).saturating_sub(metadata.len());
    budget.charge(Of::FileBytes, grown, || Place::File)?;
    Ok(bytes)
}

/// Reads the file `relative` below `folder`; a symbolic link may not lead out of it.
pub(crate) fn read_below(folder: &Path, relative: &Path, budget: &mut Budget) -> Result<Vec<u8>, AssetError> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let missing = |error: std::io::Error| {
        AssetError::file(format!("{}: {error}", relative.display()), "a readable file beside the input")
    };
    let root = folder.canonicalize().map_err(missing)?;
    let path = folder.join(relative).canonicalize().map_err(missing)?;
    if !path.starts_with(&root) {
        let found = format!("{}, a link out of the folder", relative.display());
        return Err(AssetError::file(found, "a file below the folder of the input"));
    }
    read_file(&path, budget).map_err(|mut error| {
        if error.class == ErrorClass::Asset {
            error.found = format!("{}: {}", relative.display(), error.found);
        }
        error
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_below_the_folder_pass() {
        for good in ["a.bin", "./a%20b.bin", "sub//x.png", "..∕etc", "console.bin", "com10.bin"] {
            assert!(matches!(parse(good), Ok(Target::File(_))), "{good}");
        }
        for bad in [
            "",
            ".",
            "/",
            "..",
            "a/../b",
            "%2e%2e/x",
            "/dev/zero",
            "%2Fdev/zero",
            "C:\\x",
            "c:x",
            "a\\b",
            "http://x/y",
            "javascript:1",
            "x\0.bin",
            "x%00.bin",
            "NUL",
            "sub/aux.bin",
            "Com1.txt",
            "%ff",
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
        assert_eq!(parse("a%252e").unwrap(), Target::File("a%2e".into()), "decoded once only");
    }

    #[test]
    fn data_uris_give_their_bytes() {
        let data = |uri: &str| match parse(uri) {
            Ok(Target::Data(media, bytes)) => Some((media, bytes)),
            _ => None,
        };
        assert_eq!(data("data:image/png;base64,AQID"), Some((Some("image/png".into()), vec![1, 2, 3])));
        assert_eq!(data("DATA:;base64,AQ"), Some((None, vec![1])));
        assert_eq!(data("data:,a%20b"), Some((None, b"a b".to_vec())));
        assert_eq!(data("data:;base64"), None);
        assert_eq!(data("data:;base64,???"), None);
    }
}
