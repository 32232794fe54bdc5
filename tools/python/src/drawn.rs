//! Answers as people read them, drawn by the code of the commands.

use pschema_inspect::{Explanation, Graph, codec};
use pschema_tools::kit;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// An explanation, as the bytes of its JSON, in the words of `pschema explain`.
#[pyfunction]
pub(crate) fn explanation(answer: &[u8]) -> PyResult<String> {
    let answer: Explanation = codec::decode(answer).map_err(other)?;
    Ok(kit::explanation(&answer))
}

/// A graph, as the bytes of its JSON, as the picture of `pschema graph`.
#[pyfunction]
pub(crate) fn graph_svg(answer: &[u8]) -> PyResult<String> {
    let answer: Graph = codec::decode(answer).map_err(other)?;
    Ok(kit::graph_svg(&answer))
}

fn other(problem: codec::CodecError) -> PyErr {
    PyValueError::new_err(format!("this is another answer, or was changed: {problem}"))
}
