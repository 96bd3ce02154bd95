Definition positive (n : nat) (ts : list term) : bool := definite n (matrix ts).
Lemma positive_sound : forall n ts z, positive n ts = true -> length z = n -> 0 <= value ts z.
Proof. intros n ts z H L; pose proof (definite_sound n _ z H L) as D; rewrite value_matrix in D; lra. Qed.

(* Of a form in which the first [s] variables do not stand. *)
Definition apart (s n : nat) (M : triangle) : bool :=
  (s <=? n)%nat && forallb (fun r => (fst r =? 0)%Z && forallb (Z.eqb 0) (snd r)) (firstn s M) && definite (n - s) (skipn s M).
Lemma no_entries : forall v z, forallb (Z.eqb 0) v = true -> dot v z = 0.
Proof.
  induction v as [|a v IH]; intros [|x z] H; cbn [dot forallb] in *; try reflexivity.
  apply andb_true_iff in H as [A H]; apply Z.eqb_eq in A as <-; rewrite IH by exact H; ring.
Qed.
Lemma apart_sound : forall s n M z, apart s n M = true -> length z = n -> 0 <= qf M z.
Proof.
  induction s as [|s IH]; intros n M z H L; unfold apart in H.
  - cbn [firstn forallb skipn] in H; rewrite !andb_true_iff, Nat.sub_0_r in H; destruct H as [_ H].
    pose proof (definite_sound n M z H L) as D; pose proof (norm2_nonneg z); lra.
  - destruct M as [|[a v] M]; [destruct z; cbn [qf]; lra|]; destruct z as [|x z]; [cbn [qf]; lra|].
    cbn [firstn forallb skipn fst snd qf] in *; rewrite !andb_true_iff in H; destruct H as [[Q [[A V] F]] D].
    apply Z.eqb_eq in A as ->; rewrite (no_entries v z V).
    assert (R : 0 <= qf M z); [|lra].
    destruct n as [|n]; [discriminate|]; apply (IH n M z); [|now injection L].
    unfold apart; rewrite F; cbn [Nat.sub] in D; rewrite D, !andb_true_r; exact Q.
Qed.

(* ---- V = m'P m of the products m of powers of the state: it falls with the gains at both ends ---- *)

Fixpoint mono (e : list nat) (x : list R) : R :=
  match e, x with a :: e', y :: x' => y ^ a * mono e' x' | _, _ => 1 end.
(* The derivative along x'. *)
Fixpoint dmono (e : list nat) (x x' : list R) : R :=
  match e, x, x' with
  | a :: e', y :: r, y' :: r' => INR a * y ^ pred a * y' * mono e' r + y ^ a * dmono e' r r'
  | _, _, _ => 0
  end.
Lemma dmono_lcomb : forall e x a b u v, length u = length v ->
  dmono e x (lcomb a b u v) = a * dmono e x u + b * dmono e x v.
Proof.
  induction e as [|c e IH]; intros [|y x] a b [|p u] [|q v] E; cbn [dmono lcomb length] in *; try discriminate; try ring.
  rewrite IH by lia; ring.
Qed.
Lemma mono_derivable : forall e (x x' : list (R -> R)) t,
  Forall2 (fun f g => derivable_pt_lim f t (g t)) x x' ->
  derivable_pt_lim (fun s => mono e (map (fun f => f s) x)) t (dmono e (map (fun f => f t) x) (map (fun f => f t) x')).
Proof.
  induction e as [|a e IH]; intros x x' t F; destruct F as [|f g x x' D F]; cbn [map mono dmono];
    try apply derivable_pt_lim_const.
  apply (derivable_pt_lim_mult (fun s => f s ^ a) (fun s => mono e (map (fun f => f s) x))); [|now apply IH].
  apply (derivable_pt_lim_comp f (fun y => y ^ a)); [exact D|apply derivable_pt_lim_pow].
Qed.

Definition places (n from : nat) (d : Z) : list (list Z) := map (fun i => repeat 0%Z (from + i) ++ [d]) (seq 0 n).
(* All but the first [s] of the products: with an eigenvalue 0 the first is a power of what may stay where it is. *)
Definition places_from (s n : nat) : list (list Z) := map (fun i => repeat 0%Z i ++ [1%Z]) (seq s (n - s)).
Definition falls_at_end (s n : nat) (P L : list (list Z)) (zero : list term) (K : Z) : bool :=
  let falls := times K (times (-1) (bilinear P (places n 0 1) L ++ bilinear P L (places n 0 1)) ++ zero)
               ++ times (-1) (squares (places_from s n) ++ squares L) in
  if positive n falls then true else apart s n (matrix falls).
Definition powers_fall (s n : nat) (P L M : list (list Z)) (zero_l zero_k : list term) (d K : Z) : bool :=
  (0 <? d)%Z && (0 <? K)%Z && (length L =? n)%nat && (length M =? n)%nat &&
  positive n (times K (bilinear P (places n 0 1) (places n 0 1)))
  && falls_at_end s n P L zero_l K && falls_at_end s n P M zero_k K.

Lemma at_places : forall d u v, at_ (places (length v) (length u) d) (u ++ v) = map (Rmult (IZR d)) v.
Proof.
  intros d u v; unfold at_, places; rewrite map_map.
  rewrite (map_ext _ (fun i => IZR d * nth i v 0)).
  - induction v as [|x v IH]; [reflexivity|]; cbn [length seq map nth]; f_equal; rewrite <- seq_shift, map_map; exact IH.
  - intro i; rewrite dot_place, app_nth2 by lia; do 2 f_equal; lia.
Qed.
Lemma at_places_first : forall d u v, at_ (places (length u) 0 d) (u ++ v) = map (Rmult (IZR d)) u.
Proof.
  intros d u v; unfold at_, places; rewrite map_map; cbn [Nat.add].
  rewrite (map_ext_in _ (fun i => IZR d * nth i u 0)).
  - induction u as [|x u IH]; [reflexivity|]; cbn [length seq map nth]; f_equal; rewrite <- seq_shift, map_map; exact IH.
  - intros i I; apply in_seq in I; rewrite dot_place, app_nth1 by lia; reflexivity.
Qed.
Lemma at_places_from : forall s w, at_ (places_from s (length w)) w = skipn s w.
Proof.
  intros s w; unfold at_, places_from; rewrite map_map.
  rewrite (map_ext _ (fun i => nth i w 0)); [|intro i; rewrite dot_place; ring].
  revert w; induction s as [|s IH]; intros w.
  - rewrite Nat.sub_0_r; induction w as [|x w IHw]; [reflexivity|]; cbn [length seq map nth skipn]; f_equal.
    rewrite <- seq_shift, map_map; exact IHw.
  - destruct w as [|x w]; [reflexivity|]; cbn [length Nat.sub skipn]; rewrite <- seq_shift, map_map; apply IH.
Qed.
Lemma norm2_skipn : forall s u, norm2 (skipn s u) <= norm2 u.
Proof.
  induction s as [|s IH]; intros [|x u]; cbn [skipn norm2]; try lra; specialize (IH u).
  pose proof (Rle_0_sqr x) as H; unfold Rsqr in H; lra.
Qed.
Lemma norm2_convex : forall t u v, length u = length v -> 0 <= t <= 1 ->
  norm2 (lcomb t (1 - t) u v) <= t * norm2 u + (1 - t) * norm2 v.
Proof.
  intros t; induction u as [|x u IH]; intros [|y v] E T; cbn [lcomb norm2 length] in *; try discriminate; [lra|].
  specialize (IH v ltac:(lia) T); assert (A : 0 <= t * (1 - t)) by (apply Rmult_le_pos; lra).
  pose proof (Rle_0_sqr (x - y)) as B; unfold Rsqr in B; pose proof (Rmult_le_pos _ _ A B); lra.
Qed.
Lemma at_mixed : forall rows fs z, at_ (mixed rows fs) z = at_ rows (at_ fs z).
Proof. intros; unfold at_ at 1 2, mixed; rewrite map_map; apply map_ext; intro; apply dot_combine. Qed.
Lemma map_one : forall z, map (Rmult 1) z = z.
Proof. induction z as [|x z IH]; cbn [map]; [reflexivity|]; rewrite IH; f_equal; ring. Qed.

Lemma Forall2_map : forall (A B : Type) (P : B -> B -> Prop) (f g : A -> B) l, (forall i, In i l -> P (f i) (g i)) ->
  Forall2 P (map f l) (map g l).
Proof. intros A B P f g; induction l as [|i l IH]; intro H; constructor; [apply H; left; reflexivity|]; apply IH; intros; apply H; now right. Qed.

Theorem powers_in_time : forall q n P L M zero_l zero_k d K (m m' : R -> list R),
  powers_fall q n P L M zero_l zero_k d K = true ->
  (forall t, length (m t) = n) -> (forall t, length (m' t) = n) ->
  (forall i t, (i < n)%nat -> 0 < t -> derivable_pt_lim (fun s => nth i (m s) 0) t (nth i (m' t) 0)) ->
  (forall t, value zero_l (m t) = 0 /\ value zero_k (m t) = 0) ->
  (forall t, 0 < t -> exists r, 0 <= r <= 1 /\
    map (Rmult (IZR d)) (m' t) = lcomb r (1 - r) (at_ M (m t)) (at_ L (m t))) ->
  forall i, (q <= i < n)%nat -> tends_to (fun t => nth i (m t) 0) 0.
Proof.
  intros q n P L M zero_l zero_k d K m m' test len len' D Z0 mix i I; unfold powers_fall in test.
  rewrite !andb_true_iff, !Z.ltb_lt, !Nat.eqb_eq in test.
  destruct test as [[[[[[dp Kp] lL] lM] low] fall_l] fall_k]; apply IZR_lt in dp, Kp.
  pose (z := fun t => m t ++ map (Rmult (IZR d)) (m' t)).
  pose (fs := places n 0 d); pose (gs := places n n 1); pose (rows := places_from q n).
  assert (F : forall t, at_ fs (z t) = map (Rmult (IZR d)) (m t)).
  { intro t; unfold fs, z; rewrite <- (len t) at 1; apply at_places_first. }
  assert (G : forall t, at_ gs (z t) = map (Rmult (IZR d)) (m' t)).
  { intro t; pose proof (at_places 1 (m t) (map (Rmult (IZR d)) (m' t))) as H.
    rewrite map_length, len, len', map_one in H; exact H. }
  assert (Rw : forall w, length w = n -> at_ rows w = skipn q w) by (intros w E; unfold rows; rewrite <- E; apply at_places_from).
  assert (own : forall w, length w = n -> at_ (places n 0 1) w = w).
  { intros w E; rewrite <- (app_nil_r w) at 1; rewrite <- E, at_places_first; apply map_one. }
  assert (end_falls : forall N_ zero, falls_at_end q n P N_ zero K = true -> forall t, value zero (m t) = 0 ->
    norm2 (skipn q (m t)) + norm2 (at_ N_ (m t))
    <= - (IZR K * (sumprod (m t) (map (fun r => dot r (at_ N_ (m t))) P)
      + sumprod (at_ N_ (m t)) (map (fun r => dot r (m t)) P)))).
  { intros N_ zero test t z0; unfold falls_at_end in test.
    match type of test with (if positive ?k ?f then _ else _) = true =>
      assert (H : 0 <= value f (m t)) by (destruct (positive k f) eqn:E;
        [now apply (positive_sound k)|pose proof (apart_sound q k _ _ test (len t)) as A; rewrite value_matrix in A; lra]) end.
    clear test.
    repeat (rewrite value_app in H || rewrite value_times in H); rewrite !value_bilinear, !squares_at, z0 in H.
    fold rows in H; rewrite !own, Rw in H by apply len; lra. }
  assert (scaled : forall r us, dot r (map (Rmult (IZR d)) us) = IZR d * dot r us).
  { induction r as [|a row IH]; intros [|x us]; cbn [dot map]; try ring; rewrite IH; ring. }
  assert (first : forall us vs, sumprod (map (Rmult (IZR d)) us) vs = IZR d * sumprod us vs).
  { induction us as [|x us IH]; intros [|y vs]; cbn [sumprod map]; try ring; rewrite IH; ring. }
  assert (second : forall us vs, sumprod us (map (Rmult (IZR d)) vs) = IZR d * sumprod us vs).
  { induction us as [|x us IH]; intros [|y vs]; cbn [sumprod map]; try ring; rewrite IH; ring. }
  assert (lim : forall row, In row rows -> tends_to (fun t => dot row (at_ fs (z t))) 0).
  { apply (in_time_by (2 * n) P fs gs rows [] [] (IZR K * IZR d) z (fun _ => 0)).
    - apply Rmult_lt_0_compat; assumption.
    - intros w Lw; rewrite app_nil_r, value_bilinear; fold (V P (at_ fs w)).
      assert (Lu : length (firstn n w) = n) by (rewrite firstn_length; lia).
      rewrite <- (firstn_skipn n w); unfold fs; rewrite <- Lu at 1; rewrite at_places_first, V_scaled.
      apply Rmult_le_pos; [apply Rlt_le; now apply Rmult_lt_0_compat|].
      pose proof (positive_sound n _ (firstn n w) low Lu) as H; rewrite value_times, value_bilinear, own in H by exact Lu.
      apply (Rmult_le_reg_l (IZR K)); [exact Kp|rewrite Rmult_0_r; exact H].
    - intro t; unfold z; rewrite app_length, map_length, len, len'; lia.
    - unfold flows, fs, gs, places; apply Forall2_map; intros j J t T; apply in_seq in J.
      apply (derivable_same (fun s => IZR d * nth j (m s) 0) _ t (IZR d * nth j (m' t) 0)).
      + intro s; rewrite dot_place; unfold z; rewrite app_nth1; [reflexivity|rewrite len; lia].
      + rewrite dot_place; unfold z; rewrite app_nth2, len by (rewrite len; lia).
        replace (n + j - n)%nat with j by lia.
        rewrite (nth_indep (map (Rmult (IZR d)) (m' t)) 0 (IZR d * 0)) by (rewrite map_length, len'; lia).
        rewrite (map_nth (Rmult (IZR d))); ring.
      + apply (derivable_pt_lim_scal (fun s => nth j (m s) 0)); apply D; [lia|exact T].
    - intros; cbn; lra.
    - intros; cbn; apply derivable_pt_lim_const.
    - intros t T; rewrite !squares_at, !at_mixed, F, G, !Rw by (rewrite ?map_length, ?len, ?len'; reflexivity).
      rewrite !value_bilinear, F, G; destruct (mix t T) as [r [R01 E]]; rewrite E.
      destruct (Z0 t) as [zl zk].
      pose proof (end_falls L zero_l fall_l t zl) as A; pose proof (end_falls M zero_k fall_k t zk) as B.
      assert (EL : length (at_ M (m t)) = length (at_ L (m t))) by (unfold at_; rewrite !map_length; lia).
      pose proof (norm2_convex r _ _ EL R01) as C.
      rewrite sumprod_left, sumprod_right by exact EL; cbn [value].
      set (u := at_ L (m t)) in *; set (v := at_ M (m t)) in *.
      rewrite (map_ext (fun r0 => dot r0 (map (Rmult (IZR d)) (m t))) (fun r0 => IZR d * dot r0 (m t))) by (intro; apply scaled).
      rewrite <- (map_map (fun r0 => dot r0 (m t)) (Rmult (IZR d))), !first, !second, skipn_map, norm2_scaled.
      set (a := sumprod (m t) (map (fun r0 => dot r0 u) P)) in *; set (b := sumprod (m t) (map (fun r0 => dot r0 v) P)) in *.
      set (a' := sumprod u (map (fun r0 => dot r0 (m t)) P)) in *; set (b' := sumprod v (map (fun r0 => dot r0 (m t)) P)) in *.
      pose proof (norm2_skipn q (lcomb r (1 - r) v u)) as less.
      set (c := norm2 (lcomb r (1 - r) v u)) in *; set (w := norm2 (skipn q (m t))) in *.
      assert (H1 : r * (w + norm2 v) <= r * - (IZR K * (b + b'))) by (apply Rmult_le_compat_l; lra).
      assert (H2 : (1 - r) * (w + norm2 u) <= (1 - r) * - (IZR K * (a + a'))) by (apply Rmult_le_compat_l; lra).
      assert (H3 : w + c <= - (IZR K * (r * (b + b') + (1 - r) * (a + a')))) by lra.
      assert (d1 : 1 <= IZR d) by (apply (IZR_le 1); apply lt_IZR in dp; lia).
      assert (cpos : 0 <= c) by apply norm2_nonneg.
      assert (D2 : 1 <= IZR d * IZR d) by nra.
      assert (H4 : IZR d * IZR d * (w + c) <= IZR d * IZR d * - (IZR K * (r * (b + b') + (1 - r) * (a + a'))))
        by (apply Rmult_le_compat_l; lra).
      assert (H5 : 1 * c <= IZR d * IZR d * c) by (apply Rmult_le_compat_r; assumption).
      lra. }
  assert (J : In (repeat 0%Z i ++ [1%Z]) rows).
  { unfold rows, places_from; apply in_map_iff; exists i; split; [reflexivity|apply in_seq; lia]. }
  apply (tends_to_part (IZR d) _ (fun t => dot (repeat 0%Z i ++ [1%Z]) (at_ fs (z t)))); [|intro t|exact (lim _ J)].
  - apply (IZR_le 1); apply lt_IZR in dp; lia.
  - rewrite dot_place, F.
    rewrite (nth_indep (map (Rmult (IZR d)) (m t)) 0 (IZR d * 0)) by (rewrite map_length, len; lia).
    rewrite (map_nth (Rmult (IZR d))); ring.
Qed.

(* Forms that vanish, product by product: coefficients and places of pairs of monomials with one product. *)
Fixpoint plus (e f : list nat) : list nat :=
  match e, f with a :: e', b :: f' => (a + b)%nat :: plus e' f' | [], _ => f | _, [] => e end.
Definition pair_ := (Z * (nat * nat))%type.
Definition vanishing (es : list (list nat)) (group : list pair_) : bool :=
  (fold_right (fun p s => (fst p + s)%Z) 0%Z group =? 0)%Z &&
  match group with
  | (_, (i, j)) :: _ =>
      let g := plus (nth i es []) (nth j es []) in
      forallb (fun p => let '(_, (h, k)) := p in
        (if list_eq_dec Nat.eq_dec (plus (nth h es []) (nth k es [])) g then true else false)
        && (h <? length es)%nat && (k <? length es)%nat) group
  | [] => true
  end.
Definition vanishing_term (p : pair_) : term :=
  let '(c, (i, j)) := p in (c, (repeat 0%Z i ++ [1%Z], repeat 0%Z j ++ [1%Z])).
Definition vanishing_terms (groups : list (list pair_)) : list term := map vanishing_term (concat groups).
Lemma mono_plus : forall e f x, mono (plus e f) x = mono e x * mono f x.
Proof.
  induction e as [|a e IH]; intros [|b f] [|y x]; cbn [plus mono]; try ring; rewrite IH, pow_add; ring.
Qed.
Lemma vanishing_sound : forall es groups x, forallb (vanishing es) groups = true ->
  value (vanishing_terms groups) (map (fun e => mono e x) es) = 0.
Proof.
  intros es groups x; induction groups as [|group groups IH]; intro H; [reflexivity|].
  cbn [forallb] in H; apply andb_true_iff in H as [A H]; specialize (IH H); unfold vanishing_terms in *; cbn [concat].
  rewrite map_app, value_app, IH.
  unfold vanishing in A; apply andb_true_iff in A as [S0 A]; apply Z.eqb_eq in S0.
  destruct group as [|[c0 [i0 j0]] group]; [cbn; ring|].
  set (g := plus (nth i0 es []) (nth j0 es [])) in A; rewrite forallb_forall in A.
  assert (E : forall ps, (forall p, In p ps -> In p ((c0, (i0, j0)) :: group)) ->
    value (map vanishing_term ps) (map (fun e => mono e x) es) = IZR (fold_right (fun p s => (fst p + s)%Z) 0%Z ps) * mono g x).
  { induction ps as [|[c [i j]] ps IHp]; intro K; cbn [map value fold_right fst vanishing_term]; [ring|].
    rewrite IHp by (intros p I; apply K; now right); rewrite !dot_place, plus_IZR.
    pose proof (A _ (K (c, (i, j)) (or_introl eq_refl))) as B; cbv beta iota in B.
    destruct (list_eq_dec _ _ _) as [e|]; [|discriminate]; cbn [andb] in B.
    apply andb_true_iff in B as [B1 B2]; apply Nat.ltb_lt in B1, B2.
    assert (M : forall h, (h < length es)%nat -> nth h (map (fun e => mono e x) es) 0 = mono (nth h es []) x).
    { intros h L; rewrite (nth_indep _ 0 (mono [] x)) by (rewrite map_length; exact L).
      apply (map_nth (fun e => mono e x)). }
    rewrite (M i B1), (M j B2), <- e, mono_plus; ring. }
  rewrite Rplus_0_r; etransitivity; [exact (E _ (fun p I => I))|].
  match goal with |- IZR ?s * _ = 0 => replace s with 0%Z by (symmetry; exact S0) end; ring.
Qed.

Lemma monos_derivable : forall es (x x' : list (R -> R)), (forall t, 0 < t ->
    Forall2 (fun f g => derivable_pt_lim f t (g t)) x x') -> forall i t, (i < length es)%nat -> 0 < t ->
  derivable_pt_lim (fun s => nth i (map (fun e => mono e (map (fun f => f s) x)) es) 0) t
    (nth i (map (fun e => dmono e (map (fun f => f t) x) (map (fun f => f t) x')) es) 0).
Proof.
  intros es x x' D; induction es as [|e es IH]; intros [|i] t L T; cbn [length map nth] in *; try lia.
  - now apply mono_derivable, D.
  - apply IH; [lia|exact T].
Qed.
Lemma mixed_ends : forall es x u v w d r L M, length u = length v -> w = lcomb r (1 - r) v u ->
  at_ L (map (fun e => mono e x) es) = map (fun e => d * dmono e x u) es ->
  at_ M (map (fun e => mono e x) es) = map (fun e => d * dmono e x v) es ->
  map (Rmult d) (map (fun e => dmono e x w) es)
  = lcomb r (1 - r) (at_ M (map (fun e => mono e x) es)) (at_ L (map (fun e => mono e x) es)).
Proof.
  intros es x u v w d r L M E -> -> ->; induction es as [|e es IH]; [reflexivity|]; cbn [map lcomb]; rewrite IH; f_equal.
  rewrite dmono_lcomb by congruence; ring.
Qed.
(* Between the ends u is the mean of what it is there, with weights q > 0. *)
Lemma mean_of_ends : forall r l h p q u, 0 <= r <= 1 -> 0 < l -> 0 < h -> u * (r * h + (1 - r) * l) = r * q + (1 - r) * p ->
  exists s, 0 <= s <= 1 /\ u = s * (q / h) + (1 - s) * (p / l).
Proof.
  intros r l h p q u R L H E; pose proof (Rmult_le_pos r h ltac:(lra) ltac:(lra)) as A.
  pose proof (Rmult_le_pos (1 - r) l ltac:(lra) ltac:(lra)) as B.
  assert (P : 0 < r * h + (1 - r) * l).
  { destruct (Rle_or_lt r (1 / 2)); [pose proof (Rmult_lt_0_compat (1 - r) l ltac:(lra) L)|pose proof (Rmult_lt_0_compat r h ltac:(lra) H)]; lra. }
  exists (r * h / (r * h + (1 - r) * l)); split.
  - split; apply (Rmult_le_reg_r (r * h + (1 - r) * l)); try exact P; unfold Rdiv; rewrite ?Rmult_assoc, ?Rinv_l; lra.
  - apply (Rmult_eq_reg_r (r * h + (1 - r) * l)); [rewrite E; field|]; lra.
Qed.
(* Sums of functions that tend to 0, or have derivatives. *)
Lemma sums_vanish : forall fs, Forall (fun f => tends_to f 0) fs ->
  forall c, tends_to (fun t => dot c (map (fun f : R -> R => f t) fs)) 0.
Proof.
  intros fs F; induction F as [|f fs D F IH]; intros [|a c]; cbn [map dot];
    try (intros eps epos; exists 0; intros t _; rewrite Rminus_0_r, Rabs_R0; lra).
  replace 0 with (IZR a * 0 + 0) by ring.
  apply (tends_plus (fun t => IZR a * f t) (fun t => dot c (map (fun g : R -> R => g t) fs))); [|apply IH].
  now apply (tends_scal (IZR a) f).
Qed.
Lemma sums_derivable : forall fs gs t, Forall2 (fun f g => derivable_pt_lim f t (g t)) fs gs ->
  forall c, derivable_pt_lim (fun s => dot c (map (fun f : R -> R => f s) fs)) t (dot c (map (fun g : R -> R => g t) gs)).
Proof.
  intros fs gs t F; induction F as [|f g fs gs D F IH]; intros [|a c]; cbn [map dot]; try apply derivable_pt_lim_const.
  apply (derivable_pt_lim_plus (fun s => IZR a * f s) (fun s => dot c (map (fun f : R -> R => f s) fs))); [|apply IH].
  now apply (derivable_pt_lim_scal f).
Qed.
Lemma tends_to_power : forall f p, (0 < p)%nat -> tends_to (fun t => f t ^ p) 0 -> tends_to f 0.
Proof.
  intros f p pp H eps epos; destruct (H (eps ^ p)) as [T HT]; [now apply pow_lt|]; exists T; intros t Ht.
  specialize (HT t Ht); rewrite Rminus_0_r in *; rewrite <- RPow_abs in HT.
  destruct (Rlt_or_le (Rabs (f t)) eps) as [L|L]; [exact L|exfalso].
  pose proof (pow_incr eps (Rabs (f t)) p ltac:(lra)); lra.
Qed.
