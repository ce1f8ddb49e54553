# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
