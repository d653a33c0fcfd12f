//! What runs wrote, for people.
//!
//! | folder | what |
//! | --- | --- |
//! | `picture` | frames and the contact sheet of a run that goes on |
//! | `page` | one HTML page of a run, from what its folder holds; as a file, or served |
//! | `diff` | two runs or recordings compared |
//! | `plane` | what can only be drawn in the plane |
//! | `table` | tables of numbers in CSV |

pub mod diff;
pub mod page;
pub mod picture;
mod plane;
pub mod table;
