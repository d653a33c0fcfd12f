//! The first message of an engine: is it who is waited for, does it speak this protocol, may it join?

use crate::language::error::Error;
use crate::language::header::{FieldHeader, PROTOCOL_VERSION, other_protocol};
use crate::language::message::{Hello, Role, ToCoupler};

use super::check::{parse, unexpected};

/// The hello of the engine of this seat, without the token that it showed.
pub(super) fn hello(
    role: Role,
    token: Option<&str>,
    header: &FieldHeader,
    bytes: &[u8],
) -> Result<Hello, Error> {
    let mut hello = match read(role, header, bytes)? {
        ToCoupler::Hello(hello) => hello,
        other => return Err(unexpected(role.seat(), 0, &other, "Hello")),
    };
    if hello.protocol != PROTOCOL_VERSION {
        return Err(other_protocol(role.seat(), hello.protocol));
    }
    let refused = |why: String| {
        let who = role.seat().to_owned();
        Err(Error::Handshake { who, why })
    };
    if hello.role != role {
        return refused(format!(
            "`{}` takes the seat {}, expected {}",
            hello.engine,
            hello.role.seat(),
            role.seat()
        ));
    }
    match (token, hello.token.take()) {
        (Some(expected), Some(shown)) if shown == expected => Ok(hello),
        (None, _) => Ok(hello),
        (Some(_), shown) => {
            let what = shown.map_or("no token", |_| "another token than the run's");
            let remedy = "an engine takes it from SILLAGE_TOKEN, or from the file `token` in the run's folder";
            refused(format!("`{}` shows {what}: {remedy}", hello.engine))
        }
    }
}

/// An engine that was built before there were tokens ends its hello one member earlier: it shows none.
fn read(role: Role, header: &FieldHeader, bytes: &[u8]) -> Result<ToCoupler, Error> {
    const HELLO: u8 = 0;
    const NONE: u8 = 0;
    let told = parse(role.seat(), 0, header, bytes);
    if told.is_ok() || bytes.first() != Some(&HELLO) {
        return told;
    }
    let longer = [bytes, &[NONE]].concat();
    let header = FieldHeader {
        count: longer.len() as u64,
        ..*header
    };
    parse(role.seat(), 0, &header, &longer).or(told)
}
