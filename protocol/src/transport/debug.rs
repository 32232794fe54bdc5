//! How types that hold ports print.

/// Gives types that hold ports, which do not print, a `Debug` that prints their name.
macro_rules! opaque_debug {
    ($($type:ident),+) => {$(
        impl std::fmt::Debug for $type {
            fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                to.write_str(stringify!($type))
            }
        }
    )+};
}
pub(super) use opaque_debug;
