//! Lines and columns of a source's bytes, both from 1, columns in characters.

/// Bytes between two marks: what a search goes through.
const STEP: usize = 4096;

/// Finds lines and columns anywhere in a source in the same short time.
pub(crate) struct Places<'s> {
    source: &'s str,
    /// Bytes with their line and column, the first of all and one after each step.
    marks: Vec<(usize, usize, usize)>,
}

impl<'s> Places<'s> {
    pub(crate) fn new(source: &'s str) -> Self {
        let mut marks = vec![(0, 1, 1)];
        let (mut line, mut column, mut next) = (1, 1, STEP);
        for (byte, c) in source.char_indices() {
            if byte >= next {
                marks.push((byte, line, column));
                next = byte + STEP;
            }
            (line, column) = after(c, line, column);
        }
        Self { source, marks }
    }

    /// Line and column of a byte; beyond the end, those of the end.
    pub(crate) fn line_column(&self, byte: usize) -> (usize, usize) {
        let mark = self.marks.partition_point(|(at, ..)| *at <= byte).saturating_sub(1);
        let &(start, line, column) = self.marks.get(mark).unwrap_or(&(0, 1, 1));
        let between = self.source.get(start..).unwrap_or("").char_indices();
        between
            .take_while(|(at, _)| start + at < byte)
            .fold((line, column), |(line, column), (_, c)| after(c, line, column))
    }
}

/// The place after a character.
fn after(c: char, line: usize, column: usize) -> (usize, usize) {
    if c == '\n' { (line + 1, 1) } else { (line, column + 1) }
}

/// The byte at a line and a column, both from 1; the end of the source beyond it.
pub(crate) fn byte_at(source: &str, line: usize, column: usize) -> usize {
    let mut start = 0;
    for _ in 1..line {
        match source[start..].find('\n') {
            Some(end) => start += end + 1,
            None => return source.len(),
        }
    }
    source[start..].char_indices().nth(column.saturating_sub(1)).map_or(source.len(), |(i, _)| start + i)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_that_counting_finds() {
        // Lines of many lengths, across several marks, with characters of 1 to 4 bytes.
        let line = |i: usize| "aé→🦀".repeat(i * i % 97) + "\n";
        let source: String = (0..150).map(line).chain([" ".repeat(3 * STEP), "end".to_owned()]).collect();
        assert!(source.len() > 6 * STEP);
        let places = Places::new(&source);
        let (mut line, mut column) = (1, 1);
        for (byte, c) in source.char_indices() {
            assert_eq!(places.line_column(byte), (line, column), "byte {byte}");
            if byte % 61 == 0 {
                assert_eq!(byte_at(&source, line, column), byte);
            }
            (line, column) = if c == '\n' { (line + 1, 1) } else { (line, column + 1) };
        }
        assert_eq!(places.line_column(source.len()), (line, column));
        assert_eq!(places.line_column(usize::MAX), (line, column));
        assert_eq!(Places::new("").line_column(0), (1, 1));
    }
}
