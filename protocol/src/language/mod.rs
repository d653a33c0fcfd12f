//! What is said: fields and their header, messages, the parts of a scene, the bytes of all of them, and
//! what goes wrong; and an engine's side of the exchange. Read `field`, `message`, `header`, `scene`,
//! `engine`.

pub mod codec;
pub mod engine;
pub mod error;
pub mod field;
pub mod header;
pub mod message;
pub mod report;
pub mod role;
pub mod scene;
