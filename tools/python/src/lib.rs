//! The native half of the Python package `pschema`: what a program in Python says is put into the words of the Rust crates, which do
//! all the work, and what they answer is put back. The other half is `package/pschema`, beside this folder.

mod arm;
mod body;
mod client;
mod declared;
mod drawn;
mod errors;
mod eye;
mod learner;
mod stop;
mod values;

use pschema_protocol::limits;
use pyo3::prelude::*;

/// What `pschema` imports. Its interface is `package/pschema/_native.pyi`, and is the package's own.
#[pymodule]
mod _native {
    use super::*;
    #[pymodule_export]
    use crate::arm::Arm;
    #[pymodule_export]
    use crate::body::run;
    #[pymodule_export]
    use crate::client::{Client, Past};
    #[pymodule_export]
    use crate::declared::check;
    #[pymodule_export]
    use crate::drawn::{explanation, graph_svg};
    #[pymodule_export]
    use crate::eye::Eye;
    #[pymodule_export]
    use crate::learner::Learner;
    #[pymodule_export]
    use crate::stop::Stop;
    #[pymodule_export]
    use crate::values::Action;

    #[pymodule_init]
    fn named(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        // Each is what it is called in `protocol/src/limits.rs`.
        module.add("ACTIONS_MAX", limits::ACTIONS_MAX)?;
        module.add("BODIES_MAX", limits::BODIES_MAX)?;
        module.add("PICTURE_FIELDS_MAX", limits::PICTURE_FIELDS_MAX)?;
        module.add("PICTURE_PIXELS_MAX", limits::PICTURE_PIXELS_MAX)?;
        module.add("PRIMITIVES_MAX", limits::PRIMITIVES_MAX)?;
        module.add("PROPERTIES_MAX", limits::PROPERTIES_MAX)?;
        module.add("SYMBOLS_MAX", limits::SYMBOLS_MAX)
    }
}
