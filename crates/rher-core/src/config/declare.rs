//! How settings are declared: everything about a setting stands in one place.

/// Declares a section of the settings.
///
/// A field is a setting, with its documentation, its type, its range (every value of the type if
/// there is none), and the value that it starts from: that of the preset `paper`, that of `fast`
/// where it differs, and that of `sample_efficient` where it differs from that of `fast`.
/// `sections` are fields that are declared by themselves, and `unwritten` are fields that no file
/// has.
macro_rules! settings {
    (
        $(#[doc = $about:literal])*
        pub struct $name:ident in $prefix:literal, from $start:ident {
            $(
                $(#[doc = $doc:literal])*
                $(#[serde $serde:tt])?
                pub $field:ident: $type:ty {
                    $(range: $range:expr,)?
                    paper: $paper:expr,
                    $(fast: $fast:expr,)?
                    $(sample_efficient: $sample_efficient:expr,)?
                }
            )*
            $(sections {
                $(pub $section:ident: $section_type:ty,)*
            })?
            $(unwritten {
                $(
                    $(#[doc = $unwritten_doc:literal])*
                    #[serde $unwritten_serde:tt]
                    pub $unwritten:ident: $unwritten_type:ty = $unwritten_value:expr,
                )*
            })?
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $($(#[doc = $doc])* $(#[serde $serde])? pub $field: $type,)*
            $($(
                #[doc = concat!("The section `[", stringify!($section), "]`.")]
                pub $section: $section_type,
            )*)?
            $($(
                $(#[doc = $unwritten_doc])*
                #[serde $unwritten_serde]
                pub $unwritten: $unwritten_type,
            )*)?
        }

        impl $name {
            /// Lines of its documentation.
            pub const DOC: &'static [&'static str] = &[$($about),*];

            /// Its settings, without those of its sections.
            pub const SETTINGS: &'static [$crate::setting::Setting] = &[
                $($crate::setting::Setting {
                    key: concat!($prefix, stringify!($field)),
                    doc: &[$($doc),*],
                    kind: <$type as $crate::setting::Value>::KIND,
                    range: settings!(@first $($range,)? $crate::setting::Range::Any),
                },)*
            ];

            $(
                /// The parts of a settings file, without what is set about the environments.
                pub const SECTIONS: &'static [$crate::setting::Section] = &[
                    $crate::setting::Section {
                        name: "",
                        doc: Self::DOC,
                        settings: Self::SETTINGS,
                    },
                    $($crate::setting::Section {
                        name: stringify!($section),
                        doc: <$section_type>::DOC,
                        settings: <$section_type>::SETTINGS,
                    },)*
                ];
            )?

            pub(in crate::config) fn starting_from($start: &$crate::config::preset::Start<'_>) -> Self {
                use $crate::config::Preset;
                Self {
                    $($field: match $start.preset {
                        Preset::Paper => $paper,
                        Preset::Fast => settings!(@first $($fast,)? $paper),
                        Preset::SampleEfficient => {
                            settings!(@first $($sample_efficient,)? $($fast,)? $paper)
                        }
                    },)*
                    $($($section: <$section_type>::starting_from($start),)*)?
                    $($($unwritten: $unwritten_value,)*)?
                }
            }

            /// Shows every setting and its value to `visitor`, in the order of the file.
            pub fn visit<V: $crate::setting::SettingVisitor>(
                &self,
                visitor: &mut V,
            ) -> Result<(), V::Error> {
                let mut settings = Self::SETTINGS.iter();
                $(if let Some(setting) = settings.next() {
                    visitor.visit(setting, &self.$field)?;
                })*
                $($(self.$section.visit(visitor)?;)*)?
                Ok(())
            }
        }
    };
    (@first $first:expr $(, $other:expr)*) => {
        $first
    };
}

pub(super) use settings;
