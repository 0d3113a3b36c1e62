//! Brackets, before anything is read: how deep they are, and whether each is closed.

use super::{MAX_DEPTH, Scan, is_word};
use crate::error::PresetErrorKind;
use crate::places::Places;
use crate::syntax::Fault;

impl Scan<'_> {
    /// Checks the depth of brackets and that each is closed, before `ron` recurses into them, and leaves the
    /// cursor at the start. What is wrong with brackets is best said at the one that opens.
    pub(crate) fn brackets(&mut self) -> Result<(), Fault> {
        let mut open: Vec<(char, usize)> = Vec::new();
        let mut ended = true;
        while let Some(c) = self.peek() {
            match c {
                '(' | '[' | '{' => {
                    open.push((c, self.at));
                    self.at += 1;
                    if open.len() > MAX_DEPTH {
                        return Err(Fault {
                            message: format!(
                                "values are nested more than {MAX_DEPTH} deep; no flag raises this"
                            ),
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
                _ if self.pass(c).is_none() => {
                    ended = false;
                    break;
                }
                _ => {}
            }
        }
        let fault = open.pop().filter(|_| ended).map(|(last, at)| self.unclosed(last, at));
        self.at = 0;
        fault.map_or(Ok(()), Err)
    }

    /// Passes what begins with `c` at the cursor and is no bracket; `None` where a text has no end.
    fn pass(&mut self, c: char) -> Option<()> {
        match c {
            '"' | 'r' | 'b' if self.text_prefix().is_some() => self.text()?,
            '\'' => self.character(),
            '/' if self.rest().starts_with("//") || self.rest().starts_with("/*") => self.space(),
            _ if is_word(c) => self.at = self.token_end(),
            _ => self.at += c.len_utf8(),
        }
        Some(())
    }

    /// The innermost bracket that is open at the byte `end`.
    pub(crate) fn open_before(&mut self, end: usize) -> Option<usize> {
        let mut open = Vec::new();
        self.at = 0;
        while self.at < end {
            match self.peek()? {
                '(' | '[' | '{' => {
                    open.push(self.at);
                    self.at += 1;
                }
                ')' | ']' | '}' => {
                    open.pop();
                    self.at += 1;
                }
                c => self.pass(c)?,
            }
        }
        open.pop()
    }

    fn unclosed(&self, opener: char, at: usize) -> Fault {
        let closer = match opener {
            '(' => ')',
            '[' => ']',
            _ => '}',
        };
        let (span, token) = self.token();
        let found = if self.at_end() { "the preset ends".to_owned() } else { format!("found `{token}`") };
        let (line, column) = Places::new(self.source).line_column(at);
        Fault {
            message: format!("expected `{closer}`, {found}"),
            span,
            kind: PresetErrorKind::Syntax,
            help: Some(format!("the `{opener}` at line {line}, column {column} is not closed")),
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
