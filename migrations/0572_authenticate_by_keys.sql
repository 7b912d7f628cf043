-- Keys with which the service authenticates as a client, and values of the claim acr that count as a second factor.
CREATE TABLE client_keys (
    kid TEXT PRIMARY KEY NOT NULL, -- RFC 7638
    private_sealed BLOB NOT NULL, -- opens with the key file, for this row only
    public_jwk TEXT NOT NULL,
    signs_from INTEGER NOT NULL -- until the next key does
) STRICT;

ALTER TABLE sign_in_providers ADD COLUMN second_factor_acr TEXT NOT NULL DEFAULT '[]'; -- JSON: list
