//! Hands the problem of `scenarios/paper_plan.toml` to a solver of one's own, through pipes: first its sizes, limits, start and
//! non-zeros, then to each request `e` (x) or `d` (x, weight, multipliers) its values or derivatives. Numbers are
//! little-endian, counts of 8 bytes, values of 8. An answer begins with 1, or with 0 where there is none.
//! `validation/paper_nlp/serve.py` is one such solver.

use std::io::{Read, Write};

use wingbeat::ocp::nlp::{Derivatives, Program};
use wingbeat_validate::{Error, paper_nlp};

fn main() -> Result<(), Error> {
    let mut end = Ok(());
    paper_nlp::on_the_robot(&mut |program, start| end = serve(program, start))?;
    end.map_err(|error| Error::NoAnswer(error.to_string()))
}

fn put(out: &mut impl Write, values: &[f64]) -> std::io::Result<()> {
    values.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))
}

fn counts(out: &mut impl Write, values: impl Iterator<Item = usize>) -> std::io::Result<()> {
    values.into_iter().try_for_each(|value| out.write_all(&(value as u64).to_le_bytes()))
}

fn take(from: &mut impl Read, values: &mut [f64]) -> std::io::Result<()> {
    let mut bytes = [0; 8];
    values.iter_mut().try_for_each(|value| {
        from.read_exact(&mut bytes)?;
        *value = f64::from_le_bytes(bytes);
        Ok(())
    })
}

fn serve(program: &mut dyn Program, start: &[f64]) -> std::io::Result<()> {
    let (mut from, mut out) = (std::io::stdin().lock(), std::io::stdout().lock());
    let structure = program.structure();
    let (n, m) = (program.variables().len(), program.constraints().len());
    counts(&mut out, [n, m, structure.jacobian.len(), structure.hessian.len()].into_iter())?;
    for channels in [program.variables(), program.constraints()] {
        put(&mut out, &channels.iter().flat_map(|c| [c.low, c.high]).collect::<Vec<f64>>())?;
    }
    put(&mut out, start)?;
    for entries in [&structure.jacobian, &structure.hessian] {
        counts(&mut out, entries.iter().flat_map(|&(row, column)| [row, column]))?;
    }
    out.flush()?;
    let (mut x, mut g, mut y, mut weight) = (vec![0.0; n], vec![0.0; m], vec![0.0; m], [0.0]);
    let mut derivatives = Derivatives::new(n, &structure);
    let mut asked = [0];
    while from.read_exact(&mut asked).is_ok() {
        take(&mut from, &mut x)?;
        if asked == *b"e" {
            match program.evaluate(&x, &mut g) {
                Ok(objective) => {
                    put(&mut out, &[1.0, objective])?;
                    put(&mut out, &g)?;
                }
                Err(_) => put(&mut out, &[0.0])?,
            }
        } else {
            take(&mut from, &mut weight)?;
            take(&mut from, &mut y)?;
            match program.differentiate(&x, weight[0], &y, &mut derivatives) {
                Ok(()) => {
                    put(&mut out, &[1.0])?;
                    put(&mut out, &derivatives.gradient)?;
                    put(&mut out, &derivatives.jacobian)?;
                    put(&mut out, &derivatives.hessian)?;
                }
                Err(_) => put(&mut out, &[0.0])?,
            }
        }
        out.flush()?;
    }
    Ok(())
}
