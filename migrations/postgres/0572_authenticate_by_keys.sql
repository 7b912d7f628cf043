-- Keys with which the service authenticates as a client, and values of the claim acr that count as a second factor.
CREATE TABLE client_keys (
    kid TEXT COLLATE "C" PRIMARY KEY, -- RFC 7638
    private_sealed BYTEA NOT NULL, -- opens with the key file, for this row only
    public_jwk TEXT COLLATE "C" NOT NULL,
    signs_from BIGINT NOT NULL -- until the next key does
);

ALTER TABLE sign_in_providers ADD COLUMN second_factor_acr TEXT COLLATE "C" NOT NULL DEFAULT '[]'; -- JSON: list
