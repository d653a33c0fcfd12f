//! A formula in x, y, z and t.

use exmex::{Express, FlatEx};

/// What a formula may depend on, in the order of [`Formula::at`].
const VARIABLES: [&str; 4] = ["x", "y", "z", "t"];
/// Which of them only space has.
const DEPTH: usize = 2;

/// A formula in x, y, z \[m\] and t \[s\].
#[derive(Debug, Clone)]
pub struct Formula {
    expression: FlatEx<f64>,
    /// For each variable of the expression, which of [`VARIABLES`] it is.
    uses: Vec<usize>,
}

impl Formula {
    /// Parse a formula; the error names what is not understood.
    pub fn parse(text: &str) -> Result<Formula, String> {
        let expression = FlatEx::<f64>::parse(text).map_err(|error| error.to_string())?;
        let index = |name: &String| {
            let known = VARIABLES.iter().position(|variable| variable == name);
            known.ok_or_else(|| format!("`{name}` is not known; variables are x, y, z and t"))
        };
        let uses = expression
            .var_names()
            .iter()
            .map(index)
            .collect::<Result<_, _>>()?;
        Ok(Formula { expression, uses })
    }

    /// Does it depend on z?
    pub fn has_depth(&self) -> bool {
        self.uses.contains(&DEPTH)
    }

    /// Its value at a point and a time; z of the plane is 0.
    pub fn at(&self, point: &[f64], t: f64) -> Result<f64, String> {
        let variable = |&k: &usize| match k {
            3 => t,
            axis => point.get(axis).copied().unwrap_or(0.0),
        };
        let values: Vec<f64> = self.uses.iter().map(variable).collect();
        let value = self
            .expression
            .eval(&values)
            .map_err(|error| error.to_string())?;
        if value.is_finite() {
            return Ok(value);
        }
        let place = VARIABLES
            .iter()
            .zip(point)
            .map(|(name, value)| format!("{name} = {value}, "));
        Err(format!(
            "`{self}` is {value} at {}t = {t}",
            place.collect::<String>()
        ))
    }
}

impl std::fmt::Display for Formula {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.expression.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_are_what_they_say() {
        for (text, value) in [
            ("0", 0.0),
            ("-0.1*y", -0.3),
            ("x + 10*y + 100*t", 432.0),
            ("1000*z + t", 5004.0),
            ("2*sin(PI*x/4)^2", 2.0),
            ("sqrt(y+1)*exp(0*t)", 2.0),
        ] {
            let found = Formula::parse(text).and_then(|formula| formula.at(&[2.0, 3.0, 5.0], 4.0));
            println!("{text} = {found:?}");
            assert!((found.expect("a number") - value).abs() < 1e-14, "{text}");
        }
    }

    #[test]
    fn wrong_formulas_say_what_is_wrong() {
        for (text, words) in [
            ("w*2", "`w` is not known"),
            ("2*", ""),
            ("", ""),
            ("sin(x", ""),
        ] {
            let error = Formula::parse(text).expect_err("refused");
            println!("{text}: {error}");
            assert!(error.contains(words));
        }
        let error = Formula::parse("1/x").and_then(|formula| formula.at(&[0.0, 0.0], 0.0));
        println!("{error:?}");
        assert!(error.expect_err("infinite").contains("is inf at x = 0"));
    }
}
