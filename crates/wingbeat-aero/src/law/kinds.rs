//! The laws, made of their list.

/// Declares [`LiftLaw`](super::LiftLaw) with an arm for each law of the list, and what asks the law of an arm.
macro_rules! laws {
    ($($(#[$doc:meta])* $name:ident: $module:ident,)+) => {
        /// What becomes of the attached lift as the angle of attack grows.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum LiftLaw {
            $($(#[$doc])* $name,)+
        }

        impl LiftLaw {
            /// All laws.
            pub const ALL: [Self; [$(LiftLaw::$name),+].len()] = [$(Self::$name),+];

            /// What the law is, as data.
            #[inline]
            pub const fn about(self) -> &'static Law {
                match self {
                    $(Self::$name => &<$module::$name as Section>::LAW,)+
                }
            }

            /// [`Section::separation`] of the law.
            fn separation<P: Scalar>(self, numbers: &SurfaceNumbers<P>) -> P {
                match self {
                    $(Self::$name => $module::$name::separation(numbers),)+
                }
            }

            /// [`Section::broadside`] of the law.
            #[inline]
            fn broadside<P, G: Scalar + Meets<P>>(self, absolute_sine: G, relief: P) -> Option<G> {
                match self {
                    $(Self::$name => $module::$name::broadside(absolute_sine, relief),)+
                }
            }
        }
    };
}
pub(super) use laws;
