//! What runs wrote, for people.
//!
//! | folder | what |
//! | --- | --- |
//! | `picture` | frames and the contact sheet of a run that goes on |
//! | `page` | one HTML page of a run, from what its folder holds; as a file, or served |
//! | `diff` | two runs or recordings compared |
//! | `simplices`, `cut` | a mesh as it is drawn, and a plane across one of space |
//! | `table` | tables of numbers in CSV |

mod cut;
pub mod diff;
pub mod page;
pub mod picture;
mod simplices;
pub mod table;
