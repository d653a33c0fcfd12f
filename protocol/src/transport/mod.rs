//! How messages and fields cross: the trait [`channel`], the ends of the links of a run, their services
//! and one end of a link over iceoryx2, in shared memory ([`ipc`]) or on the heap ([`local`]); sending and
//! receiving with validation. Read `channel`, `ends`, `services`, `link`, `exchange`.

pub(crate) mod buffers;
pub mod channel;
pub(crate) mod descriptor;
pub(crate) mod ends;
pub(crate) mod exchange;
pub mod ipc;
pub(crate) mod link;
pub mod local;
pub(crate) mod services;
