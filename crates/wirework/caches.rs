//! Point caches: which files, of which vertices, and what stands in them.
//!
//! The vertices are those of an OBJ sequence of the same effect, in the same order and in the world; what seams weld stays apart, as it
//! does there.

use std::collections::BTreeSet;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Serialize;
use wirework_asset::{FrameStore, Gltf, MadeFile, Part, Rest, printable};
use wirework_bake::{CacheFormat, CacheHead, cache_head, cache_sample_into};

use crate::output::Pattern;
use crate::subject::Model;
use crate::{Job, JobError, Schedule};

/// In the name of a cache it stands for the name of a node: each gets a file.
const NODE: &str = "{node}";

/// A point cache that was written.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct CacheFacts {
    /// The file.
    pub path: PathBuf,
    /// Points of a sample.
    pub points: usize,
    /// Samples, one a frame.
    pub frames: usize,
}

/// A cache that is asked for.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    path: PathBuf,
    format: CacheFormat,
}

/// The caches that a job asks for, as its output and beside it.
pub(crate) fn wanted(job: &Job<'_>) -> Result<Vec<Wanted>, JobError> {
    let output = job.output.filter(|path| CacheFormat::of(path).is_some());
    let all = output.into_iter().chain(job.caches.iter().map(PathBuf::as_path));
    let one = |path: &Path| match CacheFormat::of(path) {
        Some(_) if Pattern::of(path).is_some() => Err(JobError::Request(format!(
            "{}: `####` stands for a file a frame, and a point cache holds all frames; leave it out",
            printable(&path.display().to_string())
        ))),
        Some(format) => Ok(Wanted { path: path.to_path_buf(), format }),
        None => Err(JobError::Request(format!(
            "{}: found another extension, expected a point cache: .pc2 or .mdd",
            printable(&path.display().to_string())
        ))),
    };
    all.map(one).collect()
}

impl Wanted {
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is a file for each node.
    fn is_each(&self) -> bool {
        self.path.file_name().is_some_and(|name| name.to_string_lossy().contains(NODE))
    }

    /// The file of a node.
    fn of_node(&self, node: &str) -> PathBuf {
        let name = self.path.file_name().map(|name| name.to_string_lossy().replace(NODE, node));
        self.path.with_file_name(name.unwrap_or_default())
    }
}

/// A node of a model, and where its vertices are among those of all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Member {
    name: String,
    vertices: Vec<Range<usize>>,
    /// How many vertices programs make of it that make those anew that each primitive uses, where these are others.
    remade: Option<usize>,
}

/// The nodes that a model shows, each with the vertices that it has.
pub(crate) fn members(model: &Model) -> Vec<Member> {
    match model {
        Model::Gltf { gltf, rest } => {
            let nodes = rest.parts.chunk_by(|a, b| (a.node, a.mesh) == (b.node, b.mesh));
            nodes.filter_map(|parts| member(gltf, rest, parts)).collect()
        }
        Model::Mesh { parts, .. } => parts
            .iter()
            .map(|part| Member {
                name: part.name.clone(),
                vertices: part
                    .positions
                    .iter()
                    .map(|range| range.start as usize..range.end as usize)
                    .collect(),
                remade: None,
            })
            .collect(),
    }
}

fn member(gltf: &Gltf, rest: &Rest, parts: &[Part]) -> Option<Member> {
    let first = parts.first()?;
    let blocks: BTreeSet<usize> = parts.iter().map(|part| part.block).collect();
    let vertices: Vec<Range<usize>> = blocks
        .iter()
        .filter_map(|&block| rest.blocks.get(block))
        .map(|block| block.first..block.first + block.count)
        .collect();
    let remade: Vec<usize> = parts.iter().flat_map(|part| used(rest, part)).collect();
    let same = remade.iter().copied().eq(vertices.iter().cloned().flatten());
    let remade = (!same).then_some(remade.len());
    let name = gltf.node_name(first.node).or(gltf.mesh_name(first.mesh)).unwrap_or_default().to_owned();
    Some(Member { name, vertices, remade })
}

/// The vertices that a primitive uses, in their order; of points and lines all.
fn used(rest: &Rest, part: &Part) -> Vec<usize> {
    let Some(block) = rest.blocks.get(part.block) else { return Vec::new() };
    let mut used = vec![part.triangle_count == 0; block.count];
    let triangles = rest.triangles.get(part.first_triangle..part.first_triangle + part.triangle_count);
    for &vertex in triangles.unwrap_or(&[]).as_flattened() {
        if let Some(slot) = (vertex as usize).checked_sub(block.first).and_then(|own| used.get_mut(own)) {
            *slot = true;
        }
    }
    let numbered = used.into_iter().enumerate().filter(|(_, used)| *used);
    numbered.map(|(own, _)| block.first + own).collect()
}

/// Caches on the way to their files.
pub(crate) struct Caches {
    files: Vec<CacheFile>,
    store: FrameStore,
}

struct CacheFile {
    path: PathBuf,
    format: CacheFormat,
    head: Vec<u8>,
    vertices: Vec<Range<usize>>,
}

impl Caches {
    /// The files for what was taken in.
    pub(crate) fn new(
        wanted: &[Wanted],
        members: &[Member],
        store: FrameStore,
        (schedule, fps): (&Schedule, f64),
    ) -> Result<Self, JobError> {
        let mut files = Vec::new();
        for wanted in wanted {
            let each: Vec<(PathBuf, Vec<Range<usize>>)> = if wanted.is_each() {
                let names = file_names(members);
                names.iter().zip(members).map(|(n, m)| (wanted.of_node(n), m.vertices.clone())).collect()
            } else {
                vec![(wanted.path.clone(), std::iter::once(0..store.points()).collect())]
            };
            for (path, vertices) in each {
                let points = vertices.iter().map(ExactSizeIterator::len).sum();
                let head = cache_head(wanted.format, &head(points, schedule, fps))?;
                files.push(CacheFile { path, format: wanted.format, head, vertices });
            }
        }
        Ok(Self { files, store })
    }

    /// The files to write.
    pub(crate) fn made(&self) -> Vec<MadeFile<'_>> {
        let made = self.files.iter().map(|file| MadeFile {
            path: file.path.clone(),
            folders: false,
            write: Box::new(move |out| self.write(file, out)),
        });
        made.collect()
    }

    fn write(&self, file: &CacheFile, out: &mut dyn Write) -> std::io::Result<()> {
        out.write_all(&file.head)?;
        let (mut points, mut bytes) = (Vec::new(), Vec::new());
        for frame in 0..self.store.frames() {
            bytes.clear();
            for range in &file.vertices {
                points.resize(range.len(), [0.0; 3]);
                self.store.read(frame, range.start, &mut points)?;
                cache_sample_into(file.format, &points, &mut bytes);
            }
            out.write_all(&bytes)?;
        }
        Ok(())
    }

    pub(crate) fn facts(&self) -> Vec<CacheFacts> {
        let frames = self.store.frames();
        let points = |file: &CacheFile| file.vertices.iter().map(ExactSizeIterator::len).sum();
        let one = |file: &CacheFile| CacheFacts { path: file.path.clone(), points: points(file), frames };
        self.files.iter().map(one).collect()
    }
}

/// What stands before the samples.
fn head(points: usize, schedule: &Schedule, fps: f64) -> CacheHead {
    let first_frame = match schedule {
        Schedule::Still(seconds) => seconds * fps,
        Schedule::Frames { frames, .. } => f64::from(frames.start),
    };
    CacheHead { points, first_frame, times: schedule.moments().map(|(_, seconds)| seconds).collect() }
}

/// The names of nodes as parts of names of files, all different whatever the case of letters.
fn file_names(members: &[Member]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let mut out = Vec::with_capacity(members.len());
    for member in members {
        let keep = |c: char| if c.is_alphanumeric() || "-_. ".contains(c) { c } else { '_' };
        let name: String = member.name.trim_start_matches('.').chars().map(keep).collect();
        let name = if name.trim().is_empty() { "mesh".to_owned() } else { name };
        let numbered = (2_usize..).map(|n| format!("{name}_{n}"));
        let mut names = std::iter::once(name.clone()).chain(numbered);
        out.push(names.find(|name| taken.insert(name.to_lowercase())).unwrap_or_default());
    }
    out
}

/// What those who read the caches should know.
pub(crate) fn warnings(wanted: &[Wanted], members: &[Member]) -> Vec<String> {
    let mut out = Vec::new();
    let name = |member: &Member| format!("\"{}\"", printable(&member.name));
    let whole = wanted.iter().find(|wanted| !wanted.is_each()).filter(|_| members.len() > 1);
    if let Some(wanted) = whole {
        const TOLD: usize = 8;
        let first = |member: &Member| member.vertices.first().map_or(0, |range| range.start);
        let mut list: Vec<String> =
            members.iter().take(TOLD).map(|m| format!("{} from vertex {}", name(m), first(m))).collect();
        if members.len() > TOLD {
            list.push(format!("and {} more", members.len() - TOLD));
        }
        out.push(format!(
            "{}: {} meshes are in one cache, one behind the other: {}; `{NODE}` in the name of the file writes one each [cache-of-many]",
            printable(&wanted.path.display().to_string()),
            members.len(),
            list.join(", ")
        ));
    }
    for member in members.iter().filter(|_| !wanted.is_empty()) {
        let count: usize = member.vertices.iter().map(ExactSizeIterator::len).sum();
        if let Some(remade) = member.remade {
            out.push(format!(
                "{}: its primitives share vertices or leave some out: the cache has all {count} of them, Blender makes {remade} of its own of a \
                 glTF model and takes no cache but of these; it fits the model as an .obj [cache-order]",
                name(member)
            ));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn member(name: &str) -> Member {
        Member { name: name.to_owned(), vertices: std::iter::once(0..1).collect(), remade: None }
    }

    #[test]
    fn names_of_nodes_become_names_of_files() {
        let names = ["body", "Body", "a/b:c", "", "..", "body_2", "Kleid übrig"];
        let want = ["body", "Body_2", "a_b_c", "mesh", "mesh_2", "body_2_2", "Kleid übrig"];
        assert_eq!(file_names(&names.map(member)), want);
        let wanted = Wanted { path: "x/{node}.c{node}.pc2".into(), format: CacheFormat::Pc2 };
        assert!(wanted.is_each());
        assert_eq!(wanted.of_node("a"), Path::new("x/a.ca.pc2"));
        let folder = Wanted { path: "{node}/a.pc2".into(), format: CacheFormat::Pc2 };
        assert!(!folder.is_each());
    }

    #[test]
    fn a_head_counts_from_the_first_frame() {
        let schedule = Schedule::Frames { frames: 12..14, fps: 24.0 };
        let want = CacheHead { points: 3, first_frame: 12.0, times: vec![0.5, 13.0 / 24.0] };
        assert_eq!(head(3, &schedule, 24.0), want);
        let want = CacheHead { points: 3, first_frame: 6.0, times: vec![0.25] };
        assert_eq!(head(3, &Schedule::Still(0.25), 24.0), want);
    }
}
