//! What runs wrote, for people.
//!
//! | folder | what |
//! | --- | --- |
//! | `picture` | frames and the contact sheet of a run that goes on |
//! | `page` | one HTML page of a run, from what its folder holds; as a file, or served |
//! | `diff` | two runs or recordings compared |
//! | `simplices`, `outline`, `cut` | a mesh as it is drawn, the edges of its boundary, a plane across one of space |
//! | `table` | tables of numbers in CSV |

mod cut;
pub mod diff;
mod outline;
pub mod page;
pub mod picture;
mod simplices;
pub mod table;
