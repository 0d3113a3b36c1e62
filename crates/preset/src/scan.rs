//! The places of values in text that `ron` has accepted.

mod brackets;
mod number;

use std::ops::Range;

use self::number::number;
use crate::error::escape;
use crate::tree::{Body, Entry, Name, Node};

/// How deep values may be nested. `ron`'s own limit; a preset needs about ten.
const MAX_DEPTH: usize = 128;

/// A reader of text that `ron` has accepted.
pub(crate) struct Scan<'s> {
    source: &'s str,
    at: usize,
}

impl<'s> Scan<'s> {
    /// A reader at a byte of the text.
    pub(crate) fn new(source: &'s str, at: usize) -> Self {
        Self { source, at }
    }

    /// The token at the cursor: its bytes, and itself as it may be shown.
    pub(crate) fn token(&self) -> (Range<usize>, String) {
        let span = self.at..self.token_end();
        let text = escape(self.source.get(span.clone()).unwrap_or(""));
        (span, text)
    }

    /// Whether the cursor is at the end.
    pub(crate) fn at_end(&self) -> bool {
        self.at >= self.source.len()
    }

    fn rest(&self) -> &'s str {
        self.source.get(self.at..).unwrap_or("")
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn eat(&mut self, c: char) -> bool {
        let found = self.peek() == Some(c);
        if found {
            self.at += c.len_utf8();
        }
        found
    }

    /// The end of the token at the cursor: a run of name and number characters, or one other character.
    fn token_end(&self) -> usize {
        let rest = self.rest();
        let word = rest.find(|c: char| !is_word(c)).unwrap_or(rest.len());
        self.at + if word > 0 { word } else { rest.chars().next().map_or(0, char::len_utf8) }
    }

    /// Skips white space and comments; block comments nest.
    pub(crate) fn space(&mut self) {
        loop {
            let rest = self.rest();
            self.at += rest.find(|c| !is_space(c)).unwrap_or(rest.len());
            let rest = self.rest();
            if rest.starts_with("//") {
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if rest.starts_with("/*") {
                self.block_comment();
            } else {
                return;
            }
        }
    }

    fn block_comment(&mut self) {
        let mut depth = 0_usize;
        loop {
            let rest = self.rest();
            if rest.starts_with("/*") {
                depth += 1;
                self.at += 2;
            } else if rest.starts_with("*/") {
                depth -= 1;
                self.at += 2;
                if depth == 0 {
                    return;
                }
            } else if let Some(c) = rest.chars().next() {
                self.at += c.len_utf8();
            } else {
                return;
            }
        }
    }

    /// Skips `#![..]` at the start.
    pub(crate) fn attributes(&mut self) {
        self.space();
        while self.rest().starts_with("#!") {
            while let Some(c) = self.peek() {
                match c {
                    ']' => break,
                    '"' => drop(self.text()),
                    _ => self.at += c.len_utf8(),
                }
            }
            self.eat(']');
            self.space();
        }
    }

    /// How many bytes of `r`, `b` and `#` stand before the quote of a string literal at the cursor.
    fn text_prefix(&self) -> Option<usize> {
        let rest = self.rest();
        let letters = rest.len() - rest.trim_start_matches(['r', 'b']).len();
        let hashes = rest[letters..].len() - rest[letters..].trim_start_matches('#').len();
        let quote = rest[letters + hashes..].starts_with(['"']);
        let known = matches!(&rest[..letters], "" | "r" | "b" | "br");
        (known && quote && (hashes == 0 || rest[..letters].ends_with('r'))).then_some(letters + hashes)
    }

    /// Skips a string literal at the cursor; `None` where it has no end.
    fn text(&mut self) -> Option<()> {
        let prefix = self.text_prefix()?;
        let raw = self.rest()[..prefix].contains('r');
        let hashes = self.rest()[..prefix].bytes().filter(|&b| b == b'#').count();
        self.at += prefix + 1;
        if raw {
            let close = format!("\"{}", "#".repeat(hashes));
            match self.rest().find(&close) {
                Some(end) => self.at += end + close.len(),
                None => return None,
            }
            return Some(());
        }
        while let Some(c) = self.peek() {
            self.at += c.len_utf8();
            match c {
                '"' => return Some(()),
                '\\' => self.at += self.peek().map_or(0, char::len_utf8),
                _ => {}
            }
        }
        None
    }

    /// Skips a character literal at the cursor, where there is one.
    fn character(&mut self) {
        self.at += 1;
        if self.eat('\\') {
            self.at += self.peek().map_or(0, char::len_utf8);
            let rest = self.rest();
            let end = rest.find(|c: char| c == '\'' || c.is_whitespace()).unwrap_or(0);
            self.at += end;
            self.eat('\'');
        } else if let Some(c) = self.peek() {
            let after = self.at + c.len_utf8();
            if self.source.get(after..).is_some_and(|s| s.starts_with('\'')) {
                self.at = after + 1;
            }
        }
    }

    fn name(&mut self) -> Option<Name> {
        let start = self.at;
        if self.rest().starts_with("r#") {
            self.at += 2;
        } else if !self.peek().is_some_and(|c| c == '_' || c.is_alphabetic()) {
            return None;
        }
        let raw = self.at > start;
        let from = self.at;
        let rest = self.rest();
        // A plain name ends at `.`, `+` and `-`, a raw one does not.
        let stop = |c: char| !(is_word(c) && (raw || !matches!(c, '.' | '+' | '-')));
        self.at += rest.find(stop).unwrap_or(rest.len());
        Some(Name { text: self.source[from..self.at].to_owned(), span: start..self.at })
    }

    /// Reads the value at the cursor; `None` where there is none that could stand in a preset.
    pub(crate) fn value(&mut self, depth: usize) -> Option<Node> {
        if depth > MAX_DEPTH {
            return None;
        }
        self.space();
        let start = self.at;
        let (name, body) = if self.text_prefix().is_some() || self.rest().starts_with("b'") {
            (None, self.text_value()?)
        } else if let Some(name) = self.name() {
            self.named(name, depth)?
        } else {
            match self.peek()? {
                '(' => (None, self.parenthesis(depth)?),
                '[' => (None, Body::List(self.items(']', depth)?)),
                '{' => return None,
                '\'' => {
                    self.character();
                    (None, Body::Other("a character"))
                }
                _ => {
                    self.at = self.token_end();
                    (None, number(&self.source[start..self.at]))
                }
            }
        };
        Some(Node { span: start..self.at, name, body })
    }

    fn named(&mut self, name: Name, depth: usize) -> Option<(Option<Name>, Body)> {
        match name.text.as_str() {
            "true" => return Some((None, Body::Bool(true))),
            "false" => return Some((None, Body::Bool(false))),
            "inf" | "inff32" | "inff64" | "NaN" | "NaNf32" | "NaNf64" => {
                return Some((None, number(&name.text)));
            }
            _ => {}
        }
        let end = self.at;
        self.space();
        if self.peek() == Some('(') {
            let body = self.parenthesis(depth)?;
            return Some((Some(name), body));
        }
        self.at = end;
        Some((Some(name), Body::Bare))
    }

    fn text_value(&mut self) -> Option<Body> {
        let start = self.at;
        if self.rest().starts_with("b'") {
            self.at += 1;
            self.character();
            return Some(Body::Other("a byte"));
        }
        self.text()?;
        let text = &self.source[start..self.at];
        Some(match ron::from_str::<String>(text) {
            Ok(text) => Body::Text(text),
            Err(_) => Body::Other("a byte string"),
        })
    }

    /// Whether `name:` stands at the cursor, which it leaves behind the name.
    pub(crate) fn names_field(&mut self) -> bool {
        self.space();
        self.name().is_some() && {
            self.space();
            self.peek() == Some(':')
        }
    }

    fn parenthesis(&mut self, depth: usize) -> Option<Body> {
        let start = self.at;
        self.at += 1;
        let named = self.names_field();
        self.at = start;
        if named { self.entries(depth).map(Body::Fields) } else { self.items(')', depth).map(Body::Tuple) }
    }

    fn entries(&mut self, depth: usize) -> Option<Vec<Entry>> {
        let mut entries = Vec::new();
        self.at += 1;
        loop {
            self.space();
            if self.eat(')') {
                return Some(entries);
            }
            let key = self.name()?;
            self.space();
            if !self.eat(':') {
                return None;
            }
            entries.push(Entry { key, value: self.value(depth + 1)? });
            self.space();
            if !self.eat(',') && self.peek() != Some(')') {
                return None;
            }
        }
    }

    fn items(&mut self, close: char, depth: usize) -> Option<Vec<Node>> {
        let mut items = Vec::new();
        self.at += 1;
        loop {
            self.space();
            if self.eat(close) {
                return Some(items);
            }
            items.push(self.value(depth + 1)?);
            self.space();
            if !self.eat(',') && self.peek() != Some(close) {
                return None;
            }
        }
    }
}

/// What may stand in a name or a number.
pub(crate) fn is_word(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '.' | '+' | '-')
}

/// `ron`'s white space, which is not quite Unicode's.
fn is_space(c: char) -> bool {
    matches!(c, ' ' | '\t'..='\r' | '\u{85}' | '\u{200e}' | '\u{200f}' | '\u{2028}' | '\u{2029}')
}
