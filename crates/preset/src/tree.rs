//! A preset as typed: a tree of values, each with its place in the source.
//!
//! `ron` decides what is RON, and reads numbers and strings. It gives no places for values, though, and its
//! `deserialize_any` drops the name of `Keys(..)`; so this module finds the places in text that `ron` has accepted.
//! Where the two should ever disagree, [`parse`] reports the place and does not guess.

use std::ops::Range;

use ron::extensions::Extensions;

use crate::error::{PresetErrorKind, byte_at, escape, line_column};

/// A value as typed.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// The bytes from the value's first to its last, its name included.
    pub(crate) span: Range<usize>,
    /// The name before the parenthesis, or the bare name.
    pub(crate) name: Option<Name>,
    /// What follows the name.
    pub(crate) body: Body,
}

/// A name and its place.
#[derive(Clone, Debug)]
pub(crate) struct Name {
    pub(crate) text: String,
    pub(crate) span: Range<usize>,
}

/// The shapes of values.
#[derive(Clone, Debug)]
pub(crate) enum Body {
    /// Nothing: a bare name.
    Bare,
    /// `(name: value, ..)`.
    Fields(Vec<Entry>),
    /// `(value, ..)`.
    Tuple(Vec<Node>),
    /// `[value, ..]`.
    List(Vec<Node>),
    /// A number; of integers `integer` is exact.
    Number { value: f64, integer: Option<u64> },
    /// A string.
    Text(String),
    /// `true` or `false`.
    Bool(bool),
    /// What no preset uses; says what it is.
    Other(&'static str),
}

/// A field as typed.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) key: Name,
    pub(crate) value: Node,
}

/// Why a text is no tree: what, where, and of which kind.
pub(crate) struct Fault {
    pub(crate) message: String,
    pub(crate) span: Range<usize>,
    pub(crate) kind: PresetErrorKind,
    pub(crate) help: Option<String>,
}

impl Node {
    /// The value in an explicit `Some(value)`, or the value itself.
    pub(crate) fn unwrap_some(&self) -> &Self {
        match (&self.name, &self.body) {
            (Some(name), Body::Tuple(items)) if name.text == "Some" => match items.as_slice() {
                [inner] => inner,
                _ => self,
            },
            _ => self,
        }
    }

    /// The name, where there is one.
    pub(crate) fn name(&self) -> Option<&str> {
        self.name.as_ref().map(|name| name.text.as_str())
    }

    /// Whether this is the bare name `name`.
    pub(crate) fn is_bare(&self, name: &str) -> bool {
        matches!(self.body, Body::Bare) && self.name() == Some(name)
    }
}

/// The options that every preset is read with.
pub(crate) fn options() -> ron::Options {
    ron::Options::default().with_default_extension(
        Extensions::IMPLICIT_SOME | Extensions::UNWRAP_NEWTYPES | Extensions::UNWRAP_VARIANT_NEWTYPES,
    )
}

/// Reads a text into a tree.
pub(crate) fn parse(source: &str) -> Result<Node, Fault> {
    let mut scan = Scan { source, at: 0 };
    scan.brackets()?;
    options().from_str::<serde::de::IgnoredAny>(source).map_err(|error| syntax_fault(source, &error))?;
    scan.attributes();
    let node = scan.value(0);
    scan.space();
    match node {
        Some(node) if scan.at == source.len() => Ok(node),
        _ => Err(Fault {
            message: format!("expected a value, found `{}`", escape(&source[scan.at..scan.token_end()])),
            span: scan.at..scan.token_end(),
            kind: PresetErrorKind::Syntax,
            help: None,
        }),
    }
}

/// Whether text ends in a name: what follows may have lost its colon.
fn after_name(text: &str) -> bool {
    let word = text.trim_end().rsplit(|c| !is_word(c)).next();
    word.and_then(|word| word.chars().next()).is_some_and(char::is_alphabetic)
}

fn syntax_fault(source: &str, error: &ron::error::SpannedError) -> Fault {
    use ron::Error as E;
    let (mut start, end) = (
        byte_at(source, error.span.start.line, error.span.start.col),
        byte_at(source, error.span.end.line, error.span.end.col),
    );
    let mut scan = Scan { source, at: end };
    let message = match &error.code {
        // ron reports a missing comma as a missing bracket, at the end of the value before.
        E::ExpectedStructLikeEnd | E::ExpectedOptionEnd => "expected `,` or `)`".to_owned(),
        E::ExpectedArrayEnd => "expected `,` or `]`".to_owned(),
        E::ExpectedMapEnd => "expected `,` or `}`".to_owned(),
        E::ExpectedComma if after_name(&source[..end]) => "expected `:`, `,` or a closing bracket".to_owned(),
        E::ExpectedComma => "expected `,` or a closing bracket".to_owned(),
        E::TrailingCharacters => "expected nothing after the preset".to_owned(),
        E::Eof => "the preset ends too early".to_owned(),
        E::ExpectedMapColon => "expected `:` after the name of a field".to_owned(),
        E::ExpectedIdentifier => "expected the name of a field".to_owned(),
        E::UnexpectedChar(c) => format!("expected a value, found `{}`", escape(&c.to_string())),
        other => {
            let text = escape(&other.to_string());
            let mut chars = text.chars();
            chars.next().map(|c| c.to_lowercase().chain(chars).collect()).unwrap_or_default()
        }
    };
    let cursor_is_the_place = matches!(
        error.code,
        E::ExpectedStructLikeEnd
            | E::ExpectedOptionEnd
            | E::ExpectedArrayEnd
            | E::ExpectedMapEnd
            | E::ExpectedComma
            | E::TrailingCharacters
            | E::ExpectedMapColon
            | E::ExpectedIdentifier
            | E::UnexpectedChar(_)
            | E::Eof
    );
    if cursor_is_the_place {
        scan.space();
        start = scan.at;
    }
    let found = match source[scan.at..].chars().next() {
        Some(_) if cursor_is_the_place && !matches!(error.code, E::UnexpectedChar(_)) => {
            format!(", found `{}`", escape(&source[scan.at..scan.token_end()]))
        }
        _ => String::new(),
    };
    let span = if cursor_is_the_place { start..scan.token_end() } else { start..end.max(start) };
    Fault { message: message + &found, span, kind: PresetErrorKind::Syntax, help: None }
}

/// How deep values may be nested. `ron`'s own limit; a preset needs about ten.
const MAX_DEPTH: usize = 128;

/// A reader of text that `ron` has accepted.
struct Scan<'s> {
    source: &'s str,
    at: usize,
}

impl<'s> Scan<'s> {
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
    fn space(&mut self) {
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
    fn attributes(&mut self) {
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

    /// Checks the depth of brackets and that each is closed, before `ron` recurses into them, and leaves the
    /// cursor at the start. What is wrong with brackets is best said at the one that opens.
    fn brackets(&mut self) -> Result<(), Fault> {
        let mut open: Vec<(char, usize)> = Vec::new();
        let mut ended = true;
        while let Some(c) = self.peek() {
            match c {
                '(' | '[' | '{' => {
                    open.push((c, self.at));
                    self.at += 1;
                    if open.len() > MAX_DEPTH {
                        return Err(Fault {
                            message: format!("values are nested more than {MAX_DEPTH} deep"),
                            span: self.at - 1..self.at,
                            kind: PresetErrorKind::Limit,
                            help: None,
                        });
                    }
                }
                ')' | ']' | '}' => {
                    let opener = matching(c);
                    match open.pop() {
                        Some((last, _)) if last == opener => {}
                        Some((last, at)) => return Err(self.unclosed(last, at)),
                        // `ron` says what it makes of a bracket too many.
                        None => {
                            ended = false;
                            break;
                        }
                    }
                    self.at += 1;
                }
                '"' | 'r' | 'b' if self.text_prefix().is_some() => {
                    if self.text().is_none() {
                        ended = false;
                        break;
                    }
                }
                '\'' => self.character(),
                '/' if self.rest().starts_with("//") || self.rest().starts_with("/*") => self.space(),
                _ if is_word(c) => self.at = self.token_end(),
                _ => self.at += c.len_utf8(),
            }
        }
        let fault = open.pop().filter(|_| ended).map(|(last, at)| self.unclosed(last, at));
        self.at = 0;
        fault.map_or(Ok(()), Err)
    }

    fn unclosed(&self, opener: char, at: usize) -> Fault {
        let closer = match opener {
            '(' => ')',
            '[' => ']',
            _ => '}',
        };
        let found = if self.at < self.source.len() {
            format!("found `{}`", escape(&self.source[self.at..self.token_end()]))
        } else {
            "the preset ends".to_owned()
        };
        let (line, column) = line_column(self.source, at);
        Fault {
            message: format!("expected `{closer}`, {found}"),
            span: self.at..self.token_end(),
            kind: PresetErrorKind::Syntax,
            help: Some(format!("the `{opener}` at line {line}, column {column} is not closed")),
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

    fn value(&mut self, depth: usize) -> Option<Node> {
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

    fn parenthesis(&mut self, depth: usize) -> Option<Body> {
        let start = self.at;
        self.at += 1;
        self.space();
        let named = self.name().is_some() && {
            self.space();
            self.peek() == Some(':')
        };
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

fn matching(closer: char) -> char {
    match closer {
        ')' => '(',
        ']' => '[',
        _ => '{',
    }
}

/// What may stand in a name or a number.
fn is_word(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '.' | '+' | '-')
}

/// `ron`'s white space, which is not quite Unicode's.
fn is_space(c: char) -> bool {
    matches!(c, ' ' | '\t'..='\r' | '\u{85}' | '\u{200e}' | '\u{200f}' | '\u{2028}' | '\u{2029}')
}

fn number(text: &str) -> Body {
    match ron::from_str::<ron::Value>(text) {
        Ok(ron::Value::Number(number)) => {
            Body::Number { value: number.into_f64(), integer: ron::from_str::<u64>(text).ok() }
        }
        _ => Body::Other("no number"),
    }
}
