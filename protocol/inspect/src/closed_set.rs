//! Closed sets: enums each of whose members travels, and prints, as one word or a few.

/// Defines an enum whose members are the words given, in JSON as in print.
macro_rules! closed_set {
    ($(#[$about:meta])* $name:ident { $($(#[$meaning:meta])* $member:ident = $word:literal,)+ }) => {
        $(#[$about])*
        #[derive(
            Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize,
        )]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        pub enum $name {
            $($(#[$meaning])* #[serde(rename = $word)] $member,)+
        }

        impl $name {
            /// All members, in the order of their declaration.
            pub const ALL: &[Self] = &[$(Self::$member,)+];

            /// The member as it travels and prints.
            #[must_use]
            pub fn as_str(self) -> &'static str {
                match self {
                    $(Self::$member => $word,)+
                }
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                to.pad(self.as_str())
            }
        }
    };
}
pub(crate) use closed_set;

#[cfg(test)]
mod tests {
    use crate::{PursuitState, SchemaKind};

    #[test]
    fn a_member_travels_as_it_prints() {
        for state in PursuitState::ALL {
            let text = serde_json::to_string(state).unwrap();
            assert_eq!(text, format!("{:?}", state.to_string()));
            assert_eq!(serde_json::from_str::<PursuitState>(&text).unwrap(), *state);
        }
        assert_eq!(format!("{:>16}", SchemaKind::CounterExample), " counter-example");
        assert!(serde_json::from_str::<SchemaKind>("\"counter example\"").is_err());
    }
}
