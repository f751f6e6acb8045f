//! Settings that have one of a few named values.

/// Declares an enum whose variants have names in files, and keeps their documentation at run time.
macro_rules! choices {
    (
        $(#[doc = $about:literal])*
        pub enum $name:ident {
            $($(#[doc = $doc:literal])* $variant:ident = $text:literal,)+
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $name {
            $($(#[doc = $doc])* #[serde(rename = $text)] $variant,)+
        }

        impl $name {
            /// Every value, in the order of its declaration.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// The names of all values and their documentation.
            pub const CHOICES: &'static [$crate::setting::Choice] = &[
                $($crate::setting::Choice { name: $text, doc: &[$($doc),*] }),+
            ];

            /// Name in files and on the command line.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)+
                }
            }
        }

        impl $crate::setting::Value for $name {
            const KIND: $crate::setting::Kind = $crate::setting::Kind::Choice(Self::CHOICES);

            fn fits(&self, _: $crate::setting::Range) -> bool {
                true
            }
        }
    };
}

pub(crate) use choices;
