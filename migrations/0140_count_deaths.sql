-- A try at a job or at an upload that is whole is written down before it begins. One that did not live to its end is a death, and after
-- two deaths what was tried is set aside: kept, told, and tried again only when somebody asks for it.
ALTER TABLE jobs ADD COLUMN begun INTEGER NOT NULL DEFAULT 0 CHECK (begun IN (0, 1));
ALTER TABLE jobs ADD COLUMN deaths INTEGER NOT NULL DEFAULT 0;
ALTER TABLE uploads ADD COLUMN begun INTEGER NOT NULL DEFAULT 0 CHECK (begun IN (0, 1));
ALTER TABLE uploads ADD COLUMN deaths INTEGER NOT NULL DEFAULT 0;
