# What Doxygen and Sphinx do not read as it is meant: "@throws A if ...; B" names several errors, and digits have separators.
s|^( *///) @throws|\1 @par Throws\n\1|
s|@throws|Throws|
s/([0-9])'([0-9])/\1\2/g
