//! Splits the text of a pbrt file into tokens, each with its line.
//!
//! Measure: lines count from 1.
//! Range: any text. A string that does not end on its line, and an unknown escape, are errors.
//! Source: the tokens of pbrt-v4's file format. The crate pbrt4 was not used: it panics on statements that it does not
//! know, and its errors have no place. Tested below and in `tests/loading/pbrt/`.

use crate::scene::load::wording::LineError;
use std::borrow::Cow;

/// A token.
#[derive(Debug, Clone, PartialEq)]
pub enum Token<'a> {
    /// A string in quotes, without them.
    Quoted(Cow<'a, str>),
    /// `[`.
    Open,
    /// `]`.
    Close,
    /// The name of a statement, a number, `true` or `false`.
    Word(&'a str),
}

/// The tokens of a text.
#[derive(Debug)]
pub struct Tokens<'a> {
    rest: &'a str,
    line: usize,
    /// A token that was read ahead, and its line.
    peeked: Option<(Token<'a>, usize)>,
}

impl<'a> Tokens<'a> {
    /// Begins at the start of a text.
    pub fn new(text: &'a str) -> Self {
        Self {
            rest: text,
            line: 1,
            peeked: None,
        }
    }

    /// Returns the next token and its line; `None` at the end of the text.
    ///
    /// # Errors
    /// If a string is not closed, or has an unknown escape.
    pub fn next(&mut self) -> Result<Option<(Token<'a>, usize)>, LineError> {
        match self.peeked.take() {
            Some(token) => Ok(Some(token)),
            None => self.read(),
        }
    }

    /// Returns the next token without consuming it.
    ///
    /// # Errors
    /// As [`next`](Self::next).
    pub fn peek(&mut self) -> Result<Option<&Token<'a>>, LineError> {
        if self.peeked.is_none() {
            self.peeked = self.read()?;
        }
        Ok(self.peeked.as_ref().map(|(token, _)| token))
    }

    /// The line that has been reached.
    pub fn line(&self) -> usize {
        self.peeked.as_ref().map_or(self.line, |(_, line)| *line)
    }

    fn read(&mut self) -> Result<Option<(Token<'a>, usize)>, LineError> {
        self.skip_blanks_and_comments();
        let line = self.line;
        let Some(first) = self.rest.chars().next() else {
            return Ok(None);
        };
        let token = match first {
            '[' => {
                self.rest = &self.rest[1..];
                Token::Open
            }
            ']' => {
                self.rest = &self.rest[1..];
                Token::Close
            }
            '"' => Token::Quoted(self.quoted()?),
            _ => {
                let ends = |c: char| c.is_ascii_whitespace() || matches!(c, '"' | '[' | ']' | '#');
                let end = self.rest.find(ends).unwrap_or(self.rest.len());
                let (word, rest) = self.rest.split_at(end);
                self.rest = rest;
                Token::Word(word)
            }
        };
        Ok(Some((token, line)))
    }

    fn skip_blanks_and_comments(&mut self) {
        loop {
            let trimmed = self
                .rest
                .trim_start_matches(|c: char| c.is_ascii_whitespace());
            let skipped = &self.rest[..self.rest.len() - trimmed.len()];
            self.line += skipped.bytes().filter(|&byte| byte == b'\n').count();
            self.rest = trimmed;
            if !self.rest.starts_with('#') {
                return;
            }
            let end = self.rest.find(['\n', '\r']).unwrap_or(self.rest.len());
            self.rest = &self.rest[end..];
        }
    }

    /// Reads a string from its opening quote to its closing one.
    fn quoted(&mut self) -> Result<Cow<'a, str>, LineError> {
        let inside = &self.rest[1..];
        let complain = |why: &str| Err((self.line, why.to_owned()));
        let mut unescaped: Option<String> = None;
        let mut characters = inside.char_indices();
        while let Some((at, character)) = characters.next() {
            match character {
                '"' => {
                    self.rest = &inside[at + 1..];
                    return Ok(match unescaped {
                        Some(text) => Cow::Owned(text),
                        None => Cow::Borrowed(&inside[..at]),
                    });
                }
                '\n' => return complain("expected a closing quote on the line of the opening one"),
                '\\' => {
                    let text = unescaped.get_or_insert_with(|| inside[..at].to_owned());
                    match characters.next().and_then(|(_, escaped)| escape(escaped)) {
                        Some(meant) => text.push(meant),
                        None => {
                            return complain(
                                r#"expected one of b, f, n, r, t, \, ' and " after a backslash"#,
                            );
                        }
                    }
                }
                other => {
                    if let Some(text) = &mut unescaped {
                        text.push(other);
                    }
                }
            }
        }
        complain("expected a closing quote, found the end of the file")
    }
}

/// The character that is meant by a backslash and this one.
fn escape(escaped: char) -> Option<char> {
    match escaped {
        'b' => Some('\u{8}'),
        'f' => Some('\u{c}'),
        'n' => Some('\n'),
        'r' => Some('\r'),
        't' => Some('\t'),
        '\\' | '\'' | '"' => Some(escaped),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all(text: &str) -> Result<Vec<(Token<'_>, usize)>, LineError> {
        let mut tokens = Tokens::new(text);
        let mut found = vec![];
        while let Some(token) = tokens.next()? {
            found.push(token);
        }
        Ok(found)
    }

    #[test]
    fn tokens_carry_their_line_numbers() {
        let text = "Shape \"sphere\" # round\n\n\"float radius\"[ 1.5]\r\n-3e2\"a\\\"b\"";
        let quoted = |text: &'static str| Token::Quoted(text.into());
        let expected = vec![
            (Token::Word("Shape"), 1),
            (quoted("sphere"), 1),
            (quoted("float radius"), 3),
            (Token::Open, 3),
            (Token::Word("1.5"), 3),
            (Token::Close, 3),
            (Token::Word("-3e2"), 4),
            (quoted("a\"b"), 4),
        ];
        assert_eq!(all(text), Ok(expected));
    }

    #[test]
    fn unterminated_strings_and_unknown_escapes_are_rejected() {
        for (text, line) in [
            ("\n\"a\nb\"", 2),
            ("\"a", 1),
            ("\"a\\", 1),
            ("\n\n\"\\q\"", 3),
        ] {
            assert_eq!(all(text).expect_err(text).0, line, "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn tokenising_arbitrary_text_terminates(text in ".{0,60}|[ \\[\\]\"\\\\#a1\n]{0,60}") {
            if let Ok(tokens) = all(&text) {
                prop_assert!(tokens.len() <= text.len());
            }
        }
    }
}
