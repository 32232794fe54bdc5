//! How a type of the format and the learner's own type that it mirrors become each other.
//!
//! The learner's types are free to change; what stands on disk is not. So nothing of the learner is encoded: a value
//! becomes a value of a type of the format first. Where both have the same parts, [`mirror!`](crate::format::mirror) writes
//! both directions; where the learner goes another way, they are written by hand.

use std::sync::Arc;

use pschema_learner::observation::{PropertyId, SymbolId, TypeId, Variable};
use pschema_learner::schema::{ObservationId, SchemaId};
use pschema_learner::vocabulary::{BodyId, PrimitiveId};

/// A type of the format, which mirrors the learner's type `Live`.
pub(crate) trait Mirror<Live>: Sized {
    /// The mirror of a value of the learner.
    fn of(live: &Live) -> Self;

    /// The value of the learner. Whether memory has what it refers to is for others to say.
    fn live(self) -> Live;
}

/// Declares types of the format, and for each of them the type of the learner that it mirrors, field by field and variant
/// by variant. A field that the learner gains or loses does not compile, so that none is forgotten on disk. A field after `..`
/// is kept elsewhere, and comes back empty. Of a variant of the learner's that came to hold more than what was written of it, the
/// values that hold more are written as another variant, `as` which it comes back: one of those after `..`, which stand after
/// all others.
macro_rules! mirror {
    () => {};
    (
        $(#[$attribute:meta])*
        struct $name:ident = $live:ty { $($(#[$about:meta])* $field:ident: $type:ty,)* $(..$absent:ident,)* }
        $($rest:tt)*
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields)]
        pub(crate) struct $name {
            $($(#[$about])* pub(crate) $field: $type,)*
        }

        impl $crate::format::mirror::Mirror<$live> for $name {
            fn of(live: &$live) -> Self {
                type Live = $live;
                let Live { $($field,)* $($absent: _,)* } = live;
                Self { $($field: $crate::format::mirror::Mirror::of($field),)* }
            }

            fn live(self) -> $live {
                type Live = $live;
                Live {
                    $($field: $crate::format::mirror::Mirror::live(self.$field),)*
                    $($absent: Default::default(),)*
                }
            }
        }

        $crate::format::mirror::mirror! { $($rest)* }
    };
    (
        $(#[$attribute:meta])*
        enum $name:ident = $live:ty {
            $($(#[$about:meta])* $variant:ident $(($($inner:ident: $content:ty),+))? $({ $($field:ident: $type:ty),* })?,)*
            $(..$more:ident($whole:ty) as $less:ident if $holds_more:path,)*
        }
        $($rest:tt)*
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields, rename_all = "snake_case")]
        pub(crate) enum $name {
            $($(#[$about])* $variant $(($($content),+))? $({ $($field: $type),* })?,)*
            $($more($whole),)*
        }

        impl $crate::format::mirror::Mirror<$live> for $name {
            fn of(live: &$live) -> Self {
                type Live = $live;
                match live {
                    $(Live::$less(whole) if $holds_more(whole) => Self::$more($crate::format::mirror::Mirror::of(whole)),)*
                    $(Live::$variant $(($($inner),+))? $({ $($field),* })? => Self::$variant
                        $(($($crate::format::mirror::Mirror::of($inner)),+))?
                        $({ $($field: $crate::format::mirror::Mirror::of($field)),* })?,)*
                }
            }

            fn live(self) -> $live {
                type Live = $live;
                match self {
                    $(Self::$variant $(($($inner),+))? $({ $($field),* })? => Live::$variant
                        $(($($crate::format::mirror::Mirror::live($inner)),+))?
                        $({ $($field: $crate::format::mirror::Mirror::live($field)),* })?,)*
                    $(Self::$more(whole) => Live::$less($crate::format::mirror::Mirror::live(whole)),)*
                }
            }
        }

        $crate::format::mirror::mirror! { $($rest)* }
    };
}
pub(crate) use mirror;

/// Types that are the same on both sides.
macro_rules! same {
    ($($type:ty),*) => {$(
        impl Mirror<$type> for $type {
            fn of(live: &$type) -> Self {
                live.clone()
            }

            fn live(self) -> $type {
                self
            }
        }
    )*};
}
same!(bool, u8, u32, u64, i64, f64, [f64; 3], [f64; 4], String);

/// What the learner numbers: on disk it is the number.
macro_rules! numbered {
    ($($live:ident: $number:ty),*) => {$(
        impl Mirror<$live> for $number {
            fn of(live: &$live) -> Self {
                live.0
            }

            fn live(self) -> $live {
                $live(self)
            }
        }
    )*};
}
numbered!(TypeId: u16, PropertyId: u16, SymbolId: u32, Variable: u8);
numbered!(ObservationId: u32, SchemaId: u32, PrimitiveId: u32, BodyId: u16);

impl Mirror<usize> for u64 {
    fn of(live: &usize) -> Self {
        *live as u64
    }

    /// A number that no list can have as an index becomes one that no list has.
    fn live(self) -> usize {
        usize::try_from(self).unwrap_or(usize::MAX)
    }
}

impl<A: Mirror<B>, B> Mirror<Box<B>> for Box<A> {
    fn of(live: &Box<B>) -> Self {
        Self::new(A::of(live))
    }

    fn live(self) -> Box<B> {
        Box::new(A::live(*self))
    }
}

impl<A: Mirror<B>, B> Mirror<Option<B>> for Option<A> {
    fn of(live: &Option<B>) -> Self {
        live.as_ref().map(A::of)
    }

    fn live(self) -> Option<B> {
        self.map(A::live)
    }
}

impl<A: Mirror<B>, B, C: Mirror<D>, D> Mirror<(B, D)> for (A, C) {
    fn of((one, other): &(B, D)) -> Self {
        (A::of(one), C::of(other))
    }

    fn live(self) -> (B, D) {
        (A::live(self.0), C::live(self.1))
    }
}

/// What the learner shares is written out wherever it is.
impl<A: Mirror<B>, B> Mirror<Arc<B>> for Box<A> {
    fn of(live: &Arc<B>) -> Self {
        Self::new(A::of(live))
    }

    fn live(self) -> Arc<B> {
        Arc::new(A::live(*self))
    }
}

/// Lists are lists on disk, however the learner keeps them.
macro_rules! lists {
    ($($list:ty),*) => {$(
        impl<A: Mirror<B>, B> Mirror<$list> for Vec<A> {
            fn of(live: &$list) -> Self {
                list(live)
            }

            fn live(self) -> $list {
                self.into_iter().map(A::live).collect()
            }
        }
    )*};
}
lists!(Vec<B>, Box<[B]>, Arc<[B]>);

/// The mirrors of all items of a list.
pub(crate) fn list<A: Mirror<B>, B>(live: &[B]) -> Vec<A> {
    live.iter().map(A::of).collect()
}
