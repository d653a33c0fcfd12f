//! Numbers and words of the bytes of a file, written as text or as they lie in memory.

use std::str::FromStr;

/// What is wrong, and where.
pub(crate) struct Fault {
    pub(crate) place: String,
    pub(crate) why: String,
}

/// How numbers lie in a binary file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout {
    /// Was it written in the other order of bytes?
    pub(crate) swapped: bool,
    /// Bytes of a `size_t`.
    pub(crate) size: usize,
}

/// A place in the bytes of a file.
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// None: numbers are words.
    pub(crate) layout: Option<Layout>,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Cursor<'a> {
        Cursor {
            bytes,
            at: 0,
            layout: None,
        }
    }

    /// What is wrong here.
    pub(crate) fn fault(&self, why: impl Into<String>) -> Fault {
        let before = &self.bytes[..self.at];
        let lines = || 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        Fault {
            place: match self.layout {
                None => format!("line {}", lines()),
                Some(_) => format!("byte {}", self.at),
            },
            why: why.into(),
        }
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn skip_blank(&mut self) {
        let blank = self.rest().iter().take_while(|b| b.is_ascii_whitespace());
        self.at += blank.count();
    }

    /// The next word.
    pub(crate) fn word(&mut self) -> Result<&'a str, Fault> {
        self.skip_blank();
        let rest = self.rest();
        let ends = rest.iter().position(u8::is_ascii_whitespace);
        let word = &rest[..ends.unwrap_or(rest.len())];
        if word.is_empty() {
            return Err(self.fault("the file ends here, inside a section"));
        }
        let text = std::str::from_utf8(word);
        let text = text.map_err(|_| self.fault("a word is expected, found other bytes"))?;
        self.at += word.len();
        Ok(text)
    }

    /// The next word as a number.
    pub(crate) fn text<T: FromStr>(&mut self) -> Result<T, Fault> {
        self.skip_blank();
        let begin = self.at;
        let word = self.word()?;
        word.parse().map_err(|_| {
            self.at = begin;
            self.fault(format!("a number is expected, found {word:?}"))
        })
    }

    /// A name: in quotes, or what is left of the line.
    pub(crate) fn name(&mut self) -> String {
        let rest = self.rest();
        let line = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += line;
        let line = String::from_utf8_lossy(&rest[..line]);
        let line = line.trim();
        let quoted = line.strip_prefix('"').and_then(|l| l.split('"').next());
        quoted.unwrap_or(line).to_owned()
    }

    /// The bytes of a number, in the order of this machine.
    fn raw<const K: usize>(&mut self, layout: Layout) -> Result<[u8; K], Fault> {
        let bytes = self.rest().first_chunk::<K>();
        let mut bytes = *bytes.ok_or_else(|| self.fault("the file ends here, inside a section"))?;
        if layout.swapped {
            bytes.reverse();
        }
        self.at += K;
        Ok(bytes)
    }

    /// An `int`.
    pub(crate) fn int(&mut self) -> Result<i64, Fault> {
        match self.layout {
            None => self.text(),
            Some(layout) => Ok(i64::from(i32::from_ne_bytes(self.raw(layout)?))),
        }
    }

    /// A `size_t`.
    pub(crate) fn size(&mut self) -> Result<u64, Fault> {
        match self.layout {
            None => self.text(),
            Some(layout) if layout.size == 4 => {
                Ok(u64::from(u32::from_ne_bytes(self.raw(layout)?)))
            }
            Some(layout) => Ok(u64::from_ne_bytes(self.raw(layout)?)),
        }
    }

    /// A `double`.
    pub(crate) fn real(&mut self) -> Result<f64, Fault> {
        match self.layout {
            None => self.text(),
            Some(layout) => Ok(f64::from_ne_bytes(self.raw(layout)?)),
        }
    }

    /// Is this many things more than the bytes that are left can hold?
    pub(crate) fn bounded(&self, count: u64, what: &str) -> Result<usize, Fault> {
        let left = self.rest().len();
        match usize::try_from(count) {
            Ok(count) if count <= left => Ok(count),
            _ => Err(self.fault(format!(
                "{count} {what} are announced, and {left} bytes are left"
            ))),
        }
    }

    /// A number of things that follow.
    pub(crate) fn count(&mut self, what: &str) -> Result<usize, Fault> {
        let count = self.size()?;
        self.bounded(count, what)
    }

    /// Numbers begin with the next line.
    pub(crate) fn begin_numbers(&mut self) {
        if self.layout.is_some() {
            let line = self.rest().iter().position(|&byte| byte == b'\n');
            self.at += line.map_or(0, |line| line + 1);
        }
    }

    /// The byte order mark of a binary file: the number 1.
    pub(crate) fn byte_order(&mut self, size: usize) -> Result<(), Fault> {
        // One byte ends the line before.
        let line = self.rest().iter().position(|&byte| byte == b'\n');
        self.at += line.map_or(0, |line| line + 1);
        let layout = |swapped| Layout { swapped, size };
        let begin = self.at;
        let found = i32::from_ne_bytes(self.raw(layout(false))?);
        match (found, found.swap_bytes()) {
            (1, _) => self.layout = Some(layout(false)),
            (_, 1) => self.layout = Some(layout(true)),
            _ => {
                self.at = begin;
                return Err(self.fault(format!(
                    "a binary file has the number 1 here, found {found}"
                )));
            }
        }
        Ok(())
    }

    /// The name of the next section, without its dollar; its numbers begin here.
    pub(crate) fn next_section(&mut self) -> Option<String> {
        loop {
            let rest = self.rest();
            let ends = rest.iter().position(|&byte| byte == b'\n');
            let line = &rest[..ends.unwrap_or(rest.len())];
            let name = line.trim_ascii().strip_prefix(b"$");
            if let Some(name) = name.filter(|name| !name.starts_with(b"End")) {
                // A binary section begins with the byte after this line.
                self.at += ends.map_or(line.len(), |end| end + 1);
                return Some(String::from_utf8_lossy(name).into_owned());
            }
            self.at += ends? + 1;
        }
    }

    /// The end of a section that was read.
    pub(crate) fn end(&mut self, section: &str) -> Result<(), Fault> {
        self.skip_blank();
        let begin = self.at;
        let expected = format!("$End{section}");
        let word = self.word().map_err(|fault| Fault {
            why: format!("{expected} is expected; {}", fault.why),
            ..fault
        })?;
        if word == expected {
            return Ok(());
        }
        self.at = begin;
        Err(self.fault(format!("{expected} is expected, found {word:?}")))
    }

    /// Leave a section that is not read.
    pub(crate) fn skip(&mut self, section: &str) -> Result<(), Fault> {
        let end = format!("$End{section}");
        let found = self.rest().windows(end.len());
        match found
            .into_iter()
            .position(|window| window == end.as_bytes())
        {
            Some(offset) => {
                self.at += offset + end.len();
                Ok(())
            }
            None => Err(self.fault(format!("the section ${section} has no {end}"))),
        }
    }
}
