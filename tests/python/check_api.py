"""Checks an OpenAPI document by the rules of OpenAPI 3.1: check_api.py FILE. Prints what breaks them, and how many operations there are."""

import json
import sys

from openapi_spec_validator import OpenAPIV31SpecValidator

with open(sys.argv[1], encoding="utf-8") as file:
    document = json.load(file)
errors = [f"{'/'.join(map(str, error.absolute_path))}: {error.message}" for error in OpenAPIV31SpecValidator(document).iter_errors()]
print("\n".join(errors), file=sys.stderr)
methods = {"get", "put", "post", "delete", "options", "head", "patch"}
print(sum(len(methods & set(item)) for item in document["paths"].values()))
sys.exit(bool(errors))
