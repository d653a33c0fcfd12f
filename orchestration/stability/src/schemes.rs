//! The schemes that are compared.

/// The schemes that are compared, from the least implicit to the default.
pub const SCHEMES: [(&str, &str); 4] = [
    ("explicit", "\"explicit\""),
    ("semi-implicit", "\"semi-implicit\""),
    ("staggered", "\"staggered\""),
    (
        DEFAULT,
        "{ iterated = { tolerance = 1e-3, passes_max = 60 } }",
    ),
];

/// The scheme that must be stable everywhere.
pub const DEFAULT: &str = "iterated";
