//! Point caches: where every point is at every frame, and nothing else. Blender's Mesh Cache modifier, 3ds Max, Maya, Houdini and
//! `LightWave` read them.
//!
//! A `.pc2` is, in little-endian order, `POINTCACHE2` with a zero behind it, `i32` 1, points, `f32` number of the first frame, `f32` frames
//! from one sample to the next, `i32` samples, and the samples: three `f32` a point. A `.mdd` is, in big-endian order, `i32` samples, points,
//! the time of each sample in seconds as `f32`, and the samples.
//!
//! One sample is written a frame. Blender, where it counts in frames, looks neither at the first frame of a `.pc2` nor at the times of an
//! `.mdd`: sample `k` is frame `k` + *Frame Start* of its scene. Where it counts in seconds it divides the time of a `.pc2` by the frame
//! rate twice; the times of an `.mdd` are right there.

use std::path::Path;

use thiserror::Error;

/// How a cache is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CacheFormat {
    /// Point Cache 2.
    Pc2,
    /// `LightWave`'s motion designer.
    Mdd,
}

impl CacheFormat {
    /// The format that the extension of a path names: `.pc2` or `.mdd`.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        match () {
            () if extension.eq_ignore_ascii_case("pc2") => Some(Self::Pc2),
            () if extension.eq_ignore_ascii_case("mdd") => Some(Self::Mdd),
            () => None,
        }
    }
}

/// What stands before the samples of a cache.
#[derive(Clone, Debug, PartialEq)]
pub struct CacheHead {
    /// Points of a sample.
    pub points: usize,
    /// The number of the first frame; a fraction for a still between two.
    pub first_frame: f64,
    /// The time of each sample, seconds.
    pub times: Vec<f64>,
}

/// Why there can be no cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "a point cache holds at most {} points and as many frames, not {points} points in {frames} frames",
    i32::MAX
)]
pub struct CacheError {
    /// Points of a sample.
    pub points: usize,
    /// Samples.
    pub frames: usize,
}

/// The bytes before the first sample.
///
/// # Errors
///
/// More points or samples than 2³¹ − 1.
pub fn cache_head(format: CacheFormat, head: &CacheHead) -> Result<Vec<u8>, CacheError> {
    let CacheHead { points, first_frame, times } = head;
    let error = CacheError { points: *points, frames: times.len() };
    let [count, frames] = [*points, times.len()].map(|n| i32::try_from(n).map_err(|_| error));
    let (count, frames) = (count?, frames?);
    let mut out = Vec::new();
    match format {
        CacheFormat::Pc2 => {
            out.extend_from_slice(b"POINTCACHE2\0");
            out.extend_from_slice(&1_i32.to_le_bytes());
            out.extend_from_slice(&count.to_le_bytes());
            out.extend_from_slice(&(*first_frame as f32).to_le_bytes());
            out.extend_from_slice(&1_f32.to_le_bytes());
            out.extend_from_slice(&frames.to_le_bytes());
        }
        CacheFormat::Mdd => {
            out.extend_from_slice(&frames.to_be_bytes());
            out.extend_from_slice(&count.to_be_bytes());
            out.extend(times.iter().flat_map(|&time| (time as f32).to_be_bytes()));
        }
    }
    Ok(out)
}

/// The bytes of a sample, behind what `out` holds.
pub fn cache_sample_into(format: CacheFormat, points: &[[f32; 3]], out: &mut Vec<u8>) {
    let numbers = points.as_flattened();
    match format {
        CacheFormat::Pc2 => out.extend(numbers.iter().flat_map(|c| c.to_le_bytes())),
        CacheFormat::Mdd => out.extend(numbers.iter().flat_map(|c| c.to_be_bytes())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head() -> CacheHead {
        CacheHead { points: 2, first_frame: 12.0, times: vec![0.5, 0.75] }
    }

    fn file(format: CacheFormat, head: &CacheHead, samples: &[&[[f32; 3]]]) -> Vec<u8> {
        let mut out = cache_head(format, head).unwrap();
        for points in samples {
            cache_sample_into(format, points, &mut out);
        }
        out
    }

    #[test]
    fn bytes_are_those_of_the_formats() {
        let a = [[1.0, -2.0, 0.5], [0.0, -0.0, 1e-45]];
        let b = [[3.0, 4.0, 5.0], [6.0, 7.0, 8.0]];
        let pc2 = file(CacheFormat::Pc2, &head(), &[&a, &b]);
        let want = "504f494e544341434845320001000000020000000000404100 00803f02000000 \
                    0000803f 000000c0 0000003f 00000000 00000080 01000000 \
                    00004040 00008040 0000a040 0000c040 0000e040 00000041";
        assert_eq!(hex(&pc2), want.replace(' ', ""));
        let mdd = file(CacheFormat::Mdd, &head(), &[&a, &b]);
        let want = "00000002 00000002 3f000000 3f400000 \
                    3f800000 c0000000 3f000000 00000000 80000000 00000001 \
                    40400000 40800000 40a00000 40c00000 40e00000 41000000";
        assert_eq!(hex(&mdd), want.replace(' ', ""));
    }

    fn hex(bytes: &[u8]) -> String {
        use std::fmt::Write;
        bytes.iter().fold(String::new(), |mut text, byte| {
            write!(text, "{byte:02x}").unwrap();
            text
        })
    }

    #[test]
    fn names_say_which() {
        let of = |name: &str| CacheFormat::of(Path::new(name));
        assert_eq!(of("a/b.PC2"), Some(CacheFormat::Pc2));
        assert_eq!(of("b.mdd"), Some(CacheFormat::Mdd));
        assert_eq!((of("b.abc"), of("pc2"), of(".mdd")), (None, None, None));
    }

    #[test]
    fn counts_that_do_not_fit_are_refused() {
        let head = CacheHead { points: 1 << 31, ..head() };
        for format in [CacheFormat::Pc2, CacheFormat::Mdd] {
            assert_eq!(cache_head(format, &head), Err(CacheError { points: 1 << 31, frames: 2 }));
        }
    }
}
